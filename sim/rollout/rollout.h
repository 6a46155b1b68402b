// One rollout: parameters and a variation in, loss, success, gradient and certificate out.
//
// A pure function of its arguments: nothing of one rollout survives into the next but caches that change no bit (the
// meshes, reference trajectories and time nodes of recent parameters).
#pragma once

#include <Eigen/Dense>
#include <functional>
#include <limits>
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
#include "sim/rollout/recording.h"
#include "sim/rollout/simulated_track.h"
#include "sim/scenarios/scene.h"

namespace knap {

struct RolloutInput {
  Eigen::VectorXd theta;            // d design parameters
  Eigen::VectorXd theta_reference;  // empty: task loss; d values: distillation against the trajectory at these …
  std::vector<double> variation;    // one value a varied key, SI
  bool want_gradient = true;
  Eigen::VectorXd controls{};            // num_controls(): open-loop values (control_commands.h), then weights of the
                                         // policy (network.h); empty where nothing is driven
  Eigen::VectorXd controls_reference{};  // … and at these controls
  // Not empty: steps of chosen length are not chosen but those chosen at these values, moved along with touchdowns
  // (adjoint.h): the losses whose differences the gradient there is of. For the task loss, without
  // a gradient of its own.
  Eigen::VectorXd theta_nodes{};
  Eigen::VectorXd controls_nodes{};
};

struct RolloutOutput {
  double loss = 0.0;
  bool success = false;
  Eigen::VectorXd gradient;          // d, or empty
  Eigen::VectorXd control_gradient;  // num_controls(), or empty
  SimulationCertificate certificate;
  double loss_rounding = 0.0;  // what rounding does to the loss, estimated (adjoint.h); 0 without a gradient
  // What the time steps, Newton and rounding do to the loss, estimated (loss_error.h): not a number for fixed steps,
  // of which nothing is known, and without a gradient.
  double loss_error = std::numeric_limits<double>::quiet_NaN();
  // In range-normalised parameters, shares of ‖g‖: by how much the gradient differs from that at frozen time nodes, and
  // from that at a quarter of the tolerance (0 where nobody asked for it: gradient.compare).
  double touchdown_share = 0.0;
  double gradient_change = 0.0;
  // Whether the gradient is that of the problem, as far as this rollout can tell: no entry in `doubts`. See
  // docs/method.md.
  bool gradient_reliable = true;
  // Why the rollout is not to be trusted, and therefore no success: which bodies pressed into one another deeper than
  // the scene allows, or passed through one another. Empty: nothing tells against it.
  std::vector<std::string> distrust;
  std::vector<std::string> doubts;  // "cut steps", "rounding", "time steps", "touchdowns", "tolerance"
  int steps = 0;                    // steps simulated, those of chosen length one by one
  // Why nothing was simulated: theta or theta_reference makes a mesh that bounds no body. Then the certificate says
  // neither finite nor converged; loss and gradient are NaN, as after every rollout that failed. Else empty.
  std::string failure{};
};

struct RecordedRollout {
  Recording recording;
  RolloutOutput output;  // without gradients; the recording of one that did not converge ends where it stopped
};

class RolloutModel {
 public:
  // `files` holds the scenario and the meshes it names (scenario_files.h). Throws std::runtime_error with one line.
  explicit RolloutModel(const std::map<std::string, std::string>& files);

  const Scene& scene() const { return source_.scene(); }
  int num_parameters() const { return source_.num_parameters(); }
  int num_controls() const { return CountControls(scene()) + CountWeights(scene()); }
  const std::optional<SceneDesign>& design() const { return source_.design(); }
  const FixedMeshes& meshes() const { return source_.meshes(); }

  // Throws std::invalid_argument when sizes do not fit the scenario or numbers are not finite; a theta that folds a
  // mesh is an outcome, see RolloutOutput::failure. `progress` may be empty.
  RolloutOutput Run(const RolloutInput& input, const std::function<void(int done, int total)>& progress);

  // All that can be seen at theta, controls and variation of `input`, at the start and at the first accepted step at or
  // after each multiple of `period` [s], 0: at every step. Throws std::invalid_argument, also when theta folds a mesh.
  RecordedRollout Record(const RolloutInput& input, double period);

  // Wall time of the last Run's parts, by the caller's clock (seconds since any origin); zero without one.
  std::function<double()> clock;
  double forward_s = 0.0;
  double gradient_s = 0.0;

 private:
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
