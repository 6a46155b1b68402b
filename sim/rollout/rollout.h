// One rollout: parameters and a variation in, loss, success, gradient and certificate out.
//
// A pure function of its arguments: nothing of one rollout survives into the next but caches that change no bit (the
// meshes and reference trajectories of recent parameters).
#pragma once

#include <Eigen/Dense>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sim/morphology/cage_design.h"
#include "sim/rollout/build_model.h"
#include "sim/rollout/loss_terms.h"
#include "sim/scenarios/scene.h"

namespace knap {

// A gradient counts as smooth while rounding moves the loss by no more than this times the scenario's tolerance times
// ‖g‖∞ (g in range-normalised parameters): then steps of 1e-6 of a range and more still show it that well. Beyond, the
// outcome hangs on so many bounces that neither differences nor an optimizer could tell this gradient from another. See
// docs/method.md.
inline constexpr double kLargestSmoothRounding = 5e-7;

struct RolloutInput {
  Eigen::VectorXd theta;            // d
  Eigen::VectorXd theta_reference;  // empty: task loss; d values: distillation against the trajectory at these
  std::vector<double> variation;    // one value a varied key, SI
  bool want_gradient = true;
};

struct RolloutOutput {
  double loss = 0.0;
  bool success = false;
  Eigen::VectorXd gradient;  // d, or empty
  SimulationCertificate certificate;
  double loss_rounding = 0.0;  // what rounding does to the loss, estimated (adjoint.h); 0 without a gradient
  bool smooth = true;          // loss_rounding ≤ kLargestSmoothRounding · tolerance · ‖g‖∞
  int steps = 0;       // whole steps simulated
};

// A rope at one instant.
struct RopeStill {
  std::vector<Pose> X_WL;     // of its links
  Eigen::Vector3d gravity_W;  // [m/s²]
};

struct RopeStills {
  RopeStill start, end;
  bool success = false;
};

class RolloutModel {
 public:
  // `files` holds the scenario and the meshes it names (scenario_files.h). Throws std::runtime_error with one line.
  explicit RolloutModel(const std::map<std::string, std::string>& files);

  const Scene& scene() const { return scene_; }
  int num_parameters() const { return design_ ? design_->num_parameters() : 0; }
  const std::optional<CageDesign>& design() const { return design_; }

  // Throws std::invalid_argument when sizes do not fit the scenario. `progress` may be empty.
  RolloutOutput Run(const RolloutInput& input, const std::function<void(int done, int total)>& progress);

  // Paths of one body without any loss, for pictures.
  BodyPath Trace(const Eigen::VectorXd& theta, const std::vector<double>& variation, const std::string& body);
  RopeStills TraceRope(const Eigen::VectorXd& theta, const std::vector<double>& variation, const std::string& rope);

  // Wall time of the last Run's parts, by the caller's clock (seconds since any origin); zero without one.
  std::function<double()> clock;
  double forward_s = 0.0;
  double gradient_s = 0.0;

 private:
  struct Simulated {
    SceneModel model;
    std::unique_ptr<Dynamics> dynamics;
    std::unique_ptr<ContactModel> contacts;
    std::unique_ptr<Trajectory> trajectory;
  };
  Simulated Simulate(const Eigen::VectorXd& theta, const Scene& varied, const std::function<void(int)>& progress);
  std::shared_ptr<const ContactMesh> GetMesh(const Eigen::VectorXd& theta);
  Scene MakeVariedScene(const std::vector<double>& variation) const;

  // Reference paths of one (theta, variation), one a distillation term; empty when the reference failed.
  struct Reference {
    Eigen::VectorXd theta;
    std::vector<double> variation;
    struct Path {
      BodyPath body;                // of a position match
      std::vector<double> heights;  // of a height match
    };
    std::vector<Path> paths;
  };
  bool Succeeds(const Simulated& simulated, const Scene& varied);
  const Reference& GetReference(const RolloutInput& input, const Scene& varied);

  Scene scene_;
  std::optional<CageDesign> design_;
  std::shared_ptr<const SurfaceSampling> sampling_;  // of the designed mesh
  Eigen::VectorXd parameter_ranges_;  // upper − lower
  std::list<std::pair<Eigen::VectorXd, std::shared_ptr<const ContactMesh>>> meshes_;
  std::list<Reference> references_;
};

}  // namespace knap
