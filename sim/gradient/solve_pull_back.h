// One solve of a trajectory, linearised, and cotangents pulled back over it: the step of the adjoint (adjoint.h).
//
// With lambda = J⁻ᵀ g the multiplier of the solve that led to state k, g collecting all that depends on its increment
// xi_k, and f the formula of the solve (step_formula.h),
//
//   g = bar_xi_k + Jrᵀ bar_pose_k + c_v (bar_v_k + g0 bar_vdot_k)       pose_k = Exp(−xi) pose_{k−1} + Jr xi (tangents)
//   (p, w, a) = ∂(lambdaᵀ r)/∂(pose, v, vdot),   A = bar_vdot_k − a,   B = bar_v_k − w + g0 A
//   bar_pose_{k−1} += Exp(xi)(bar_pose_k − p)      bar_xi_{k−1} −= alpha c_v B      bar_vdot_{k−1} += g_a A
//   bar_v_{k−1} += g1 A − e c_v B                  bar_v_{k−2} += g2 A              bar_wrench = + W(lambda)
//   bar_base = ∂(bar_z_k · z_k + W · f_ext)/∂base, and z_k's part of state k joins bar_pose_k and bar_v_k before g is
//   formed (bristle_history.h for what follows for bar_z and bar_zdot)
//   bar_parameter −= ∂(lambdaᵀ r)/∂parameter
//
// All of f are powers of the step's length h, so that
//
//   h dJ/dh = −B·c_v (xi_k − alpha xi_{k−1}) − A·(vdot_k − g_a vdot_{k−1})
//             + bar_base·e zdot_{k−1} + bar_base|_contact·h_contact zdot_k − bar_zdot_k·zdot_k
//
// (the contacts' law is an ordinary differential equation, z = base + h_contact z'(z, motion): a longer step is as good
// as a base that lies further on by z').
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "sim/contact/contact_model.h"
#include "sim/integrators/bristle_history.h"
#include "sim/integrators/trajectory.h"
#include "sim/multibody/dynamics.h"

namespace knap {

// Of state k; the last two of state k−1, as far as the solve after k has found them.
struct StateBars {
  Eigen::VectorXd pose;  // tangent [per m, per rad]
  Eigen::VectorXd xi;
  Eigen::VectorXd v;
  Eigen::VectorXd vdot;
  BristleCotangents bristles;
  Eigen::VectorXd v_before;
  BristleCotangents bristles_before;

  explicit StateBars(int nv) {
    for (Eigen::VectorXd* bar : {&pose, &xi, &v, &vdot, &v_before}) bar->setZero(nv);
  }
  // Cotangents of the same state.
  void Add(const StateBars& other);
};

class SolvePullBack {
 public:
  // All must outlive it.
  SolvePullBack(const Trajectory& trajectory, Dynamics* dynamics, ContactModel* contacts);

  // Kinematics and controls of state k, as far as losses see it.
  void LoadState(int k);
  // After it, for k > 0: the solve that led there. False where its matrix cannot be factored.
  bool LoadSolve();
  // Of the contacts, after LoadSolve.
  bool IsActive(int contact) const { return contacts_->reports()[contact].active; }

  const Eigen::VectorXd& q() const { return q_; }
  const Eigen::VectorXd& v() const { return v_; }

  // A cotangent of a contact's force, as the solve that led to the loaded state has it; for the next PullBack.
  void AddForce(int contact, const Eigen::Vector3d& bar_f_W);

  // Cotangents of bodies' perturbations at the loaded state, which it overwrites: to *bars and the parameters. Returns
  // the cotangent of time.
  double AddBodies(std::vector<BodyCotangent>* bodies, StateBars* bars);

  // From the cotangents of the loaded state k to those of state k−1; the parameters' are added up.
  struct Result {
    double by_step = 0.0;  // of the step's length, at given times of the states [1/s]
    double by_time = 0.0;  // of the state's time, through prescribed motions [1/s]
  };
  Result PullBack(StateBars* bars);
  // In its place for state 0, to which no solve led.
  void PullBackStart(StateBars* bars);

  // Of the last PullBack.
  const Eigen::VectorXd& lambda() const { return lambda_; }
  const Eigen::VectorXd& by_pose() const { return joints_.pose; }  // ∂(lambda·r)/∂pose
  // (lambda·r)² and what a unit of rounding of r's terms does, squared.
  double CalcRoundingSquared() const;

  Eigen::MatrixXd& controls() { return bar_controls_; }
  // What the losses see of the parameters, what the solves' equations do, and of the contacts.
  const ParameterCotangents& by_loss() const { return by_loss_; }
  const ParameterCotangents& by_solves() const { return by_solves_; }
  ContactModel::Cotangents& by_contact() { return by_contact_; }

 private:
  void FindStep();

  const Trajectory& trajectory_;
  Dynamics* dynamics_;
  ContactModel* contacts_;
  int k_ = 0;
  int step_ = 0;  // the whole step that led to state k
  Eigen::VectorXd q_, v_, vdot_, xi_, r_, magnitude_, g_, lambda_;
  BristleState next_, now_, before_;  // of k, k−1, k−2
  Bristles base_;
  JointCotangents joints_;
  StateBars earlier_;
  std::vector<Bristle> bar_base_;
  std::vector<Eigen::Vector3d> bar_forces_;  // of contacts; none where no force is watched
  Eigen::MatrixXd bar_controls_;
  ParameterCotangents by_loss_, by_solves_;
  ContactModel::Cotangents by_contact_;
};

}  // namespace knap
