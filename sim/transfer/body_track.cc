#include "sim/transfer/body_track.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdlib>

#include "sim/math/check.h"

namespace knap {

namespace {

// Nobody asks: such signals are refused before.
[[noreturn]] void FailWithout(const char* what) {
  KNAP_CHECK(false, "a track of bodies has no {}", what);
  std::abort();
}

}  // namespace

BodyTrack::BodyTrack(const SceneModel& model, const BodyHistory& history, double step)
    : model_(model), history_(history), step_(step), kinematics_(static_cast<std::size_t>(model.tree.size())) {}

Moment BodyTrack::At(int k) {
  const BodyHistory::State& state = history_.states[static_cast<std::size_t>(k)];
  for (std::size_t i = 0; i < kinematics_.size(); ++i) {
    kinematics_[i].X_WB = state.X_WB[i];
    kinematics_[i].V = state.V[i];
  }
  // Joint coordinates of the start stand in for those that nothing looks at.
  return {k, time(k), model_.q0, model_.v0, kinematics_, this};
}

int BodyTrack::FindState(double time) const { return static_cast<int>(std::llround(time / step_)); }

Eigen::Index BodyTrack::FindInterval(int) const { FailWithout("commands"); }

double BodyTrack::GetCommand(int, Eigen::Index) const { FailWithout("commands"); }

int BodyTrack::FindForce(int) const { FailWithout("forces"); }

const Eigen::Vector3d& BodyTrack::GetForce(int, int) const { FailWithout("forces"); }

std::optional<double> BodyTrack::FindDepth(const std::vector<int>& contacts, int k) const {
  std::optional<double> deepest;
  for (const int contact : contacts) {
    const auto& [a, b] = model_.contacts[static_cast<std::size_t>(contact)].bodies;
    const auto found = history_.depth.find(std::minmax(a, b));
    if (found == history_.depth.end()) continue;
    deepest = std::max(deepest.value_or(0.0), found->second[static_cast<std::size_t>(k)]);
  }
  return deepest;
}

}  // namespace knap
