// What a RolloutModel is made of; for rollout.cc and recording.cc alone.
#pragma once

#include <Eigen/Dense>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sim/gradient/adjoint.h"
#include "sim/rollout/build_policy.h"
#include "sim/rollout/built_scene.h"
#include "sim/rollout/conditions.h"
#include "sim/rollout/control_commands.h"
#include "sim/rollout/loss_terms.h"
#include "sim/rollout/rollout.h"
#include "sim/rollout/simulated_track.h"

namespace knap {

class RolloutSimulation {
 public:
  explicit RolloutSimulation(const std::map<std::string, std::string>& files);

  const SceneSource& source() const { return source_; }
  const Scene& scene() const { return source_.scene(); }
  int num_parameters() const { return source_.num_parameters(); }
  int num_controls() const { return CountControls(scene()) + CountWeights(scene()); }

  // As RolloutModel's.
  RolloutOutput Run(const RolloutInput& input, const std::function<void(int done, int total)>& progress);
  RecordedRollout Record(const RolloutInput& input, double period);

  std::function<double()> clock;
  double forward_s = 0.0;
  double gradient_s = 0.0;

 private:
  const std::optional<SceneDesign>& design() const { return source_.design(); }

  struct Simulated : BuiltScene {
    Eigen::MatrixXd commands;  // u of the open-loop controls: a row an actuator, a column an interval
    std::unique_ptr<Dynamics> dynamics;
    std::unique_ptr<ContactModel> contacts;
    std::unique_ptr<ClosedLoop> policy;  // null without one; its commands are its own
    std::unique_ptr<Trajectory> trajectory;
    std::unique_ptr<SimulatedTrack> track;

    Watched watched() const { return {*signals, *track, scene.rollout}; }
  };

  // What the distillation terms refer to on the reference of one (theta, controls, variation), each by itself; empty
  // when the reference failed.
  struct Reference {
    Eigen::VectorXd theta, controls;
    std::vector<double> variation;
    std::vector<std::vector<double>> terms;
  };

  void CheckInput(const RolloutInput& input) const;
  void RequireSound(const Eigen::VectorXd& theta);  // throws std::invalid_argument with the fault
  struct Manner {
    std::function<void(int)> progress{};  // may be empty, as `observe`
    // After the start and every accepted step, at which dynamics and contacts stand then.
    std::function<void(const Simulated&, double time)> observe{};
    bool finer = false;                           // at a quarter of the scene's tolerance
    std::shared_ptr<const TimeNodeList> nodes{};  // may be null
  };
  Simulated Simulate(const Eigen::VectorXd& theta, const Eigen::VectorXd& controls,
                     const std::vector<double>& variation, const Manner& manner);
  // Certificate and, where the trajectory has converged, loss, success and trust.
  void Judge(const Simulated& s, const Reference* reference, SignalCotangents* bar, RolloutOutput* out) const;
  // Of a trajectory that did not converge.
  std::string DescribeStop(const Simulated& s) const;
  std::vector<std::string> FindDistrust(const Simulated& s) const;
  // The loss of the input's kind and what it puts on *bar.
  double Evaluate(const Simulated& s, const Reference* reference, SignalCotangents* bar) const;
  // Of one sweep.
  struct Gradient {
    Eigen::VectorXd design, controls;
    bool finite = true, solvable = true;
    int touchdowns = 0;  // that time nodes followed
    double loss_rounding = 0.0;
    double loss_error = 0.0;
  };
  Gradient CalcGradient(const Eigen::VectorXd& controls, const Simulated& s, const SignalCotangents& bar,
                        TimeNodes nodes) const;
  // All of it in range-normalised parameters.
  Eigen::VectorXd Normalize(const Scene& scene, const Gradient& gradient) const;
  void AddGradient(const RolloutInput& input, const Simulated& s, const Reference* reference,
                   const SignalCotangents& bar, RolloutOutput* out);

  // What a rollout that follows another one's steps needs of it; null where that one failed.
  struct Nodes {
    Eigen::VectorXd theta, controls;
    std::vector<double> variation;
    std::shared_ptr<const TimeNodeList> list;
  };

  const Reference& GetReference(const RolloutInput& input);
  std::shared_ptr<const TimeNodeList> GetNodes(const RolloutInput& input);

  SceneSource source_;
  std::list<Reference> references_;
  std::list<Nodes> nodes_;
};

}  // namespace knap
