// One rollout: parameters and a variation in, loss, success, gradient and certificate out.
//
// A pure function of its arguments: nothing of one rollout survives into the next but caches that change no bit (the
// meshes, reference trajectories and time nodes of recent parameters).
#pragma once

#include <Eigen/Dense>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sim/integrators/simulation_certificate.h"
#include "sim/rollout/recording.h"
#include "sim/scenarios/scene.h"

namespace knap {

class RolloutSimulation;
class SceneDesign;
class SceneSource;

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
  ~RolloutModel();
  RolloutModel(RolloutModel&& other) noexcept;
  RolloutModel& operator=(RolloutModel&& other) noexcept;

  const Scene& scene() const;
  int num_parameters() const;
  int num_controls() const;
  const std::optional<SceneDesign>& design() const;
  Eigen::VectorXd initial_theta() const;  // d values
  const SceneSource& source() const;      // its meshes

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
  // In a file of its own: what it is made of takes most of a compiler's time, and whoever runs rollouts needs none.
  std::unique_ptr<RolloutSimulation> simulation_;
};

}  // namespace knap
