// The exact derivative of the discrete trajectory, in one sweep from its end to its start.
//
// With lambda = J⁻ᵀ g the multiplier of the step into state k, g collecting all that depends on its increment xi_k, the
// step's equation r(pose_k, v_k, vdot_k, parameters) = 0 hands cotangents on to earlier states and to the parameters:
//
//   g = bar_xi_k + Jrᵀ bar_pose_k + c_v bar_v_k           pose_k = Exp(−xi) pose_{k−1} + Jr xi   (tangents)
//   (p, w, a) = ∂(lambdaᵀ r)/∂(pose, v, vdot)
//   bar_pose_{k−1} += Exp(xi)(bar_pose_k − p)             bar_xi_{k−1} −= alpha c_v (bar_v_k − w − g0 a)
//   bar_v_{k−1} −= g1 a,   bar_v_{k−2} −= g2 a            bar_wrench = + W(lambda)
//   bar_bristle_{k−1} = ∂(bar_bristle_k · bristle_k + W · f_ext)/∂bristle_{k−1}, and bristle_k's part of state k joins
//   bar_pose_k and bar_v_k before g is formed
//   bar_parameter −= ∂(lambdaᵀ r)/∂parameter, beside what the loss itself sees of it
//
// Where an interval of controls u begins and a feedback law has set them, u's cotangent is whole by then, and the law
// adds its share to bar_pose and bar_v of that state before g is formed.
//
// One factorisation and one pull-back a step, whatever the number of parameters. Parameters are the numbers that the
// tree is made of (dynamics.h: ParameterCotangents) save the ends of joint limits, gains of actuators and prescribed
// motions; mesh vertices in contact; points of grips; controls; the initial state. A placement moves the contacts of
// all it carries, those of bodies without freedom included.
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "sim/contact/contact_model.h"
#include "sim/integrators/feedback.h"
#include "sim/integrators/simulate.h"
#include "sim/integrators/state_cotangent.h"

namespace knap {

struct TrajectoryGradient {
  bool finite = true;
  bool solvable = true;  // every step's matrix could be factored
  // How far rounding moves the loss, to first order: every step's residual is off by what Newton left and by one unit
  // of rounding of its terms, every pose by eps · (1 m or 1 rad); the cotangents say what each is worth, and
  // independent errors add in quadrature. In the loss's unit.
  //   rounding² = Σ_k (lambda_k·r_k)² + eps² Σ_rows (lambda magnitude)² + eps² |bar_pose_k|²
  double loss_rounding = 0.0;
  Eigen::VectorXd pose0;  // of the initial pose, tangent [per m, per rad]
  Eigen::VectorXd v0;     // of the initial rates
  std::vector<BodyParameterCotangent> bodies;
  Eigen::Vector3d gravity = Eigen::Vector3d::Zero();
  Eigen::MatrixXd controls;                // like Trajectory::controls.values; zero where a feedback law set them
  std::vector<Eigen::Matrix3Xd> vertices;  // for each contact: of its mesh's vertices, empty without one
  std::vector<GripCotangent> grips;        // of their points
};

// `cotangents` sorted by state, ascending. The trajectory must have converged. `feedback`: the law that took part in
// it, or null; what the sweep finds on its controls goes to the law's parameters and on into the states (feedback.h).
TrajectoryGradient SweepAdjoint(const Trajectory& trajectory, const std::vector<StateCotangent>& cotangents,
                                Dynamics* dynamics, ContactModel* contacts, Feedback* feedback = nullptr);

}  // namespace knap
