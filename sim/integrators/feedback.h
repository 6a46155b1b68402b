// Controls that depend on the state: a closed-loop policy, as far as time stepping and its adjoint see it.
//
// At the start of interval i, in the state (q, v) at time t, the law sets the controls of some actuators; they are held
// through the interval (a zero-order hold):
//
//   u_i = pi(parameters, q, v, t)          u_i acts in steps i·hold … (i + 1)·hold − 1
//
// so within every step controls are constants and the Newton iteration does not know of the law. In the sweep back,
// all that acts on u_i has been collected when the state at the interval's start is reached; there it flows on:
//
//   (bar_q, bar_v, bar_parameters) += ∂pi/∂(q, v, parameters)ᵀ bar_u_i
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "sim/integrators/state_cotangent.h"
#include "sim/multibody/dynamics.h"

namespace knap {

// What a law may look at: the state at the start of an interval.
struct FeedbackState {
  int interval = 0;
  int state = 0;  // its index in the trajectory
  double time = 0.0;
  const Eigen::VectorXd& q;
  const Eigen::VectorXd& v;
  const std::vector<BodyKinematics>& kinematics;  // of q and v; accelerations are not to be used
};

class Feedback {
 public:
  virtual ~Feedback() = default;

  // Overwrites the controls of the law's own actuators; `controls` has one value for each actuator of the tree. Called
  // once an interval, in their order. No allocation.
  virtual void SetControls(const FeedbackState& at, Eigen::Ref<Eigen::VectorXd> controls) = 0;

  // From the cotangents of the controls of the whole interval: adds to *out, with the state's index, and to the
  // parameters' cotangents, which the law keeps. Those of its own actuators become zero, since what stood there before
  // had no say. Called once an interval, the last one first.
  virtual void PullBack(const FeedbackState& at, Eigen::Ref<Eigen::VectorXd> bar_controls,
                        std::vector<StateCotangent>* out) = 0;
};

}  // namespace knap
