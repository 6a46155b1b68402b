// What an engine of maximal coordinates simulated, as a track: poses and twists of all bodies at a series of times.
// Joint coordinates, commands and forces it has none; check_transfer.h refuses scenes that look at them.
#pragma once

#include <Eigen/Core>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "sim/rollout/build_model.h"
#include "sim/rollout/rollout_track.h"

namespace knap {

struct BodyHistory {
  struct State {
    std::vector<Pose> X_WB;   // of each body of the tree
    std::vector<Vector6d> V;  // V_WB_B
  };
  std::vector<double> time;  // ascending, from 0 [s]
  std::vector<State> states;
  // Of two bodies of which one is free, the lower index first: how deep they pressed into one another at the deepest on
  // the way to each state, at least kTouch while a force acted, 0 apart [m].
  static constexpr double kTouch = 1e-9;
  std::map<std::pair<int, int>, std::vector<double>> depth;
};

class BodyTrack final : public RolloutTrack {
 public:
  // Both must outlive it. `step` of the scene's grid [s].
  BodyTrack(const SceneModel& model, const BodyHistory& history, double step);

  int size() const override { return static_cast<int>(history_.time.size()); }
  double time(int k) const override { return history_.time[static_cast<std::size_t>(k)]; }
  bool IsStage(int) const override { return false; }
  Moment At(int k) override;

  const std::vector<Pose>& GetPoses(int k) const override { return history_.states[static_cast<std::size_t>(k)].X_WB; }
  int FindState(double time) const override;
  Eigen::Index FindInterval(int k) const override;
  double GetCommand(int row, Eigen::Index interval) const override;
  int FindForce(int k) const override;
  const Eigen::Vector3d& GetForce(int series, int k) const override;
  std::optional<double> FindDepth(const std::vector<int>& contacts, int k) const override;

 private:
  const SceneModel& model_;
  const BodyHistory& history_;
  double step_;
  std::vector<BodyKinematics> kinematics_;
};

}  // namespace knap
