// One rollout in Bullet's own dynamics: the same scene, masses, signals, losses and conditions as knap's own rollout
// (sim/rollout/rollout.h), and nothing of its dynamics, contact or time stepping.
//
// A pure function of its arguments: every rollout has a world of its own, and the pieces of recent parameters' meshes,
// which are kept, change no bit. docs/transfer.md says what is represented how.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <list>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "sim/rollout/built_scene.h"
#include "sim/transfer/body_track.h"
#include "sim/transfer/mesh_pieces.h"

namespace knap {

struct TransferOutput {
  double loss = 0.0;
  bool success = false;
  bool finite = true;  // else the simulation left the finite numbers, and loss is not a number
  // As in RolloutOutput: bodies that press into one another by more than `trust.penetration`.
  std::vector<std::string> distrust;
  double penetration = 0.0;    // the deepest contact, as a share of half the thinner body's width
  double largest_force = 0.0;  // of two bodies, over a step [N]
  int contact_onsets = 0;
  int steps = 0;
  std::string failure{};  // why nothing was simulated: theta makes a mesh that bounds no body
};

class TransferModel {
 public:
  // `files` as for RolloutModel. Throws std::runtime_error with one line, also where FindTransferFaults has one.
  explicit TransferModel(const std::map<std::string, std::string>& files);

  const Scene& scene() const { return source_.scene(); }
  const std::optional<SceneDesign>& design() const { return source_.design(); }

  // Throws std::invalid_argument when sizes do not fit the scenario or numbers are not finite. `progress` may be empty;
  // it is told whole steps of the scene's grid.
  TransferOutput Run(const Eigen::VectorXd& theta, const std::vector<double>& variation,
                     const std::function<void(int done, int total)>& progress);

  // The motion of the last Run, at the scene's grid; for tests.
  const BodyHistory& history() const { return history_; }
  const SceneModel& model() const { return built_.model; }

  // Bullet's largest step [s] and the iterations of its solver; the scene's grid is cut into equal steps no longer.
  double largest_step = 5e-4;
  int iterations = 60;

 private:
  const MeshPieces& FindPieces(const Eigen::VectorXd& theta);

  SceneSource source_;
  MeshPieces fixed_pieces_;                                   // of meshes that no theta shapes
  std::list<std::pair<Eigen::VectorXd, MeshPieces>> pieces_;  // of all meshes, at recent parameters
  BuiltScene built_;
  BodyHistory history_;
};

}  // namespace knap
