#include "sim/gradient/node_windows.h"

#include <cstddef>
#include <utility>

namespace knap {

NodeWindows::NodeWindows(const Trajectory& trajectory, const std::vector<StateCotangent>& cotangents,
                         const Dynamics& dynamics, const ContactModel& contacts)
    : trajectory_(trajectory),
      dynamics_(dynamics),
      contacts_(contacts),
      stays_(trajectory.size(), false),
      active_after_(contacts.contacts().size(), true) {
  for (const StateCotangent& at : cotangents) {
    if (!at.time) stays_[at.state] = true;
  }
}

bool NodeWindows::MayMove(int k) const {
  const bool between_steps =
      k > 0 && k + 1 < trajectory_.size() && trajectory_.formula(k - 1).is_stage && trajectory_.formula(k + 1).is_stage;
  return between_steps && !stays_[k];
}

void NodeWindows::Look(int k) {
  const bool is_stage = k > 0 && trajectory_.formula(k).is_stage;
  if (!is_stage && k + 1 < trajectory_.size()) {
    window_.reset();
    for (std::size_t i = 0; i < active_after_.size(); ++i) {
      if (!active_after_[i] || contacts_.reports()[i].active) continue;
      std::optional<Touchdown> touchdown = FindTouchdown(contacts_.contacts()[i], dynamics_.kinematics());
      if (!touchdown || (window_ && window_->touchdown.in <= touchdown->in)) continue;
      window_ = Window{static_cast<int>(i), *std::move(touchdown)};
    }
  }
  for (std::size_t i = 0; i < active_after_.size(); ++i) {
    active_after_[i] = contacts_.reports()[i].active || (is_stage && active_after_[i]);
  }
}

TimeNodeList ListFollowingNodes(const Trajectory& trajectory, const std::vector<StateCotangent>& cotangents,
                                Dynamics* dynamics, ContactModel* contacts) {
  NodeWindows windows(trajectory, cotangents, *dynamics, *contacts);
  TimeNodeList nodes = trajectory.ListNodes();
  BristleState bristles;
  const auto look = [&](int k, TimeNode* node) {
    dynamics->CalcKinematics(trajectory.q(k), trajectory.v(k), trajectory.vdot(k), trajectory.time(k));
    trajectory.GetBristles(k, &bristles);
    contacts->BeginStep(0.0, bristles.bent);
    contacts->AddWrenches(dynamics);
    windows.Look(k);
    if (node == nullptr) return;
    node->moves = windows.MayMove(k);
    // At the last state no step begins.
    if (k + 1 == trajectory.size() || !windows.window()) return;
    node->contact = windows.window()->contact;
    node->approach = windows.window()->touchdown.approach;
    node->touchdown = trajectory.time(k) + windows.window()->touchdown.in;
  };
  for (int n = trajectory.whole_steps() - 1; n >= 0; --n) {
    auto node = nodes.ends[n].rbegin();
    for (int k = trajectory.state_of_step(n + 1); k > trajectory.state_of_step(n); --k) {
      look(k, trajectory.formula(k).is_stage ? nullptr : &*node++);
    }
  }
  look(0, &nodes.start);
  return nodes;
}

}  // namespace knap
