#include "sim/gradient/following_nodes.h"

#include <utility>

namespace knap {

using Eigen::Matrix3d;
using Eigen::Vector3d;

void AddStateCotangent(const StateCotangent& at, const BodyKinematics& kin, BodyCotangent* bar) {
  const Matrix3d R_BW = kin.X_WB.R.transpose();
  const Vector3d bar_v = R_BW * at.v_W;
  const Vector3d bar_w = R_BW * at.w_W;
  bar->eta.tail<3>() += R_BW * at.p_W;
  bar->eta.head<3>() += R_BW * at.r_W + kin.V.tail<3>().cross(bar_v) + kin.V.head<3>().cross(bar_w);
  bar->V.tail<3>() += bar_v;
  bar->V.head<3>() += bar_w;
}

FollowingNodes::FollowingNodes(const Trajectory& trajectory, const std::vector<StateCotangent>& cotangents,
                               Dynamics* dynamics, ContactModel* contacts, SolvePullBack* pull)
    : trajectory_(trajectory),
      dynamics_(dynamics),
      pull_(pull),
      windows_(trajectory, cotangents, *dynamics, *contacts),
      bodies_(dynamics->tree().size()) {}

void FollowingNodes::Step::Add(bool is_stage, const SolvePullBack::Result& result, double by_time) {
  by_step += result.by_step;
  (is_stage ? by_stage : by_end) += result.by_time + by_time;
}

double FollowingNodes::AddTouchdown(const NodeWindows::Window& window, double S, StateBars* bars) {
  for (BodyCotangent& b : bodies_) b = BodyCotangent{};
  for (StateCotangent at : window.touchdown.bodies) {
    for (Vector3d* part : {&at.p_W, &at.v_W, &at.r_W, &at.w_W}) *part *= S;
    AddStateCotangent(at, dynamics_->kinematics()[at.body], &bodies_[at.body]);
  }
  const int surface = 1 - window.touchdown.approach.ball;
  for (const auto& [vertex, bar] : window.touchdown.vertices) {
    pull_->by_contact().vertices[window.contact][surface].col(vertex) += S * bar;
  }
  ++touchdowns_;
  return S + pull_->AddBodies(&bodies_, bars);
}

bool FollowingNodes::AddSolve(int k, const SolvePullBack::Result& result, double by_time, StateBars* bars) {
  const bool is_stage = trajectory_.formula(k).is_stage;
  if (!is_stage) {
    step_ = Step{};
    window_ = windows_.window();
  }
  step_.Add(is_stage, result, by_time);
  const bool begins_step = is_stage || !trajectory_.formula(k - 1).is_stage;
  if (!begins_step) return true;
  const int end = is_stage ? k + 1 : k;
  if (windows_.MayMove(end)) sum_ += node_ + step_.ByEndNode();
  node_ = step_.ByStartNode();
  if (!window_) return true;
  const double S = std::exchange(sum_, 0.0);
  if (S == 0.0) return true;  // no node can move

  StateBars probe(dynamics_->tree().nv());
  Step again;
  for (int j = end; j >= k; --j) {
    pull_->LoadState(j);
    const double at_end = j == end ? AddTouchdown(*window_, S, &probe) : 0.0;
    if (!pull_->LoadSolve()) return false;
    again.Add(trajectory_.formula(j).is_stage, pull_->PullBack(&probe), at_end);
  }
  if (windows_.MayMove(end)) sum_ += again.ByEndNode();
  node_ += again.ByStartNode();
  bars->Add(probe);
  return true;
}

void FollowingNodes::Finish(StateBars* bars) {
  if (windows_.window() && sum_ != 0.0) AddTouchdown(*windows_.window(), sum_, bars);
}

}  // namespace knap
