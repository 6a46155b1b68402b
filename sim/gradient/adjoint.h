// The exact derivative of the discrete trajectory, in one sweep from its end to its start.
//
// One factorisation and one pull-back a solve (solve_pull_back.h), whatever the number of parameters. Parameters are
// the numbers that the tree is made of (dynamics.h: ParameterCotangents) save the ends of joint limits, gains of
// actuators and prescribed motions; mesh vertices in contact; points of grips; controls; the initial state. A placement
// moves the contacts of all it carries, those of bodies without freedom included. Where an interval of controls u
// begins and a feedback law has set them, u's cotangent is whole by then, and the law adds its share to bar_pose and
// bar_v of that state before the solve into it is pulled back.
//
// Where steps have chosen lengths, what is differentiated besides is where the time grid's nodes lie. At fixed nodes a
// design that lets a body touch down earlier also changes at which phase of a step it does, and the error of the step
// with it: a small part of the loss, but its slope is multiplied by the number of steps. So the nodes follow: those
// from the start of the step in which a body touches down (touchdown.h) to the next such step move with the touchdown's
// time tau. With T_m the nodes and a_m = dJ/dh of the step to node m (solve_pull_back.h), s = dJ/dt of a state's time
// alone,
//
//   G_m = dJ/dT_m = a_m + s_m + gamma s_stage,m − a_{m+1} + (1 − gamma) s_stage,m+1
//   S = Σ G_m,    bar_y += S ∂tau/∂y,   bar_parameter += S ∂tau/∂parameter        y the state at the first of them
//
// where tau is seen from y as it was before it moved: the solves into y are pulled back once more with these cotangents
// alone. Nodes that cannot move are left out: the last one, those that a loss looks at, those where forces jump.
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "sim/contact/contact_model.h"
#include "sim/integrators/feedback.h"
#include "sim/integrators/simulate.h"
#include "sim/integrators/state_cotangent.h"

namespace knap {

enum class TimeNodes { kFrozen, kFollowing };

struct TrajectoryGradient {
  bool finite = true;
  bool solvable = true;  // every step's matrix could be factored
  int touchdowns = 0;    // that nodes followed
  // How far rounding moves the loss, to first order: every step's residual is off by what Newton left and by one unit
  // of rounding of its terms, every pose by eps · (1 m or 1 rad); the cotangents say what each is worth, and
  // independent errors add in quadrature. In the loss's unit.
  //   rounding² = Σ_k (lambda_k·r_k)² + eps² Σ_rows (lambda magnitude)² + eps² |bar_pose_k|²
  double loss_rounding = 0.0;
  // J_exact − J, as far as the time steps are to blame (loss_error.h); not a number for fixed steps.
  double loss_error = 0.0;
  Eigen::VectorXd pose0;  // of the initial pose, tangent [per m, per rad]
  Eigen::VectorXd v0;     // of the initial rates
  std::vector<BodyParameterCotangent> bodies;
  Eigen::Vector3d gravity = Eigen::Vector3d::Zero();
  Eigen::MatrixXd controls;  // like Trajectory::controls.values; zero where a feedback law set them
  std::vector<std::array<Eigen::Matrix3Xd, 2>> vertices;  // as ContactModel::Cotangents
  std::vector<GripCotangent> grips;                       // of their points
};

// `cotangents` sorted by state, ascending. The trajectory must have converged. `feedback`: the law that took part in
// it, or null; what the sweep finds on its controls goes to the law's parameters and on into the states (feedback.h).
TrajectoryGradient SweepAdjoint(const Trajectory& trajectory, const std::vector<StateCotangent>& cotangents,
                                Dynamics* dynamics, ContactModel* contacts, Feedback* feedback = nullptr,
                                TimeNodes nodes = TimeNodes::kFollowing);

}  // namespace knap
