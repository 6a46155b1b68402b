// What the time nodes of a sweep are worth, and how they follow touchdowns (adjoint.h).
#pragma once

#include <optional>
#include <vector>

#include "sim/gradient/node_windows.h"
#include "sim/gradient/solve_pull_back.h"
#include "sim/integrators/state_cotangent.h"

namespace knap {

// What a loss puts on a body in the world, as a cotangent of the body's perturbation.
void AddStateCotangent(const StateCotangent& at, const BodyKinematics& kin, BodyCotangent* bar);

class FollowingNodes {
 public:
  // All must outlive it. `cotangents`: of the losses, whose states stay where they are unless they say otherwise.
  FollowingNodes(const Trajectory& trajectory, const std::vector<StateCotangent>& cotangents, Dynamics* dynamics,
                 ContactModel* contacts, SolvePullBack* pull);

  // For every state from the last one to 0, loaded with its solve (state 0: with its contacts alone), before it is
  // pulled back.
  void Look(int k) { windows_.Look(k); }
  // After the solve into state k has been pulled back, with what the losses put on its time: adds to *bars, of state
  // k−1. False where a matrix cannot be factored. What is loaded afterwards may be another state.
  bool AddSolve(int k, const SolvePullBack::Result& result, double by_time, StateBars* bars);
  // At state 0, loaded: adds to *bars.
  void Finish(StateBars* bars);

  int touchdowns() const { return touchdowns_; }

 private:
  struct Step {
    double by_step = 0.0;
    double by_end = 0.0;  // of the times of its states
    double by_stage = 0.0;
    void Add(bool is_stage, const SolvePullBack::Result& result, double by_time);
    double ByEndNode() const { return by_step + by_end + StepFormula::kGamma * by_stage; }
    double ByStartNode() const { return -by_step + (1.0 - StepFormula::kGamma) * by_stage; }
  };
  // S ∂tau/∂(state and parameters) at the loaded state; returns what its time is worth.
  double AddTouchdown(const NodeWindows::Window& window, double S, StateBars* bars);

  const Trajectory& trajectory_;
  Dynamics* dynamics_;
  SolvePullBack* pull_;
  NodeWindows windows_;
  std::optional<NodeWindows::Window> window_;  // of the step that begins at the next node on the way back
  Step step_;                                  // of which solves are being pulled back
  double node_ = 0.0;                          // what the start of the step after is worth
  double sum_ = 0.0;                           // S so far
  int touchdowns_ = 0;
  std::vector<BodyCotangent> bodies_;
};

}  // namespace knap
