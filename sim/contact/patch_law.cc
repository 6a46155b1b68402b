#include "sim/contact/patch_law.h"

#include <algorithm>
#include <cmath>

#include "sim/math/smooth_ramp.h"

namespace knap {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

const double kTorsionLever = 2.0 * std::sqrt(2.0) / 3.0;
// Of a patch whose forces cancel to less than this share of their sum, no direction is left.
constexpr double kCancelled = 1e-12;

// A C² step from 0 at x ≤ 0 to 1 at x ≥ 1.
SmoothRamp CalcSmoothStep(double x) {
  if (x <= 0.0) return {0.0, 0.0};
  if (x >= 1.0) return {1.0, 0.0};
  return {x * x * x * (10.0 + x * (-15.0 + 6.0 * x)), 30.0 * x * x * (1.0 - x) * (1.0 - x)};
}

}  // namespace

bool PatchLaw::Evaluate(const PatchIntegrals& patch, const PatchLawInput& input) {
  patch_ = &patch;
  in_ = input;
  const ContactMaterial& material = *in_.material;
  N_ = patch.F.norm();
  if (!(N_ > kCancelled * material.stiffness * patch.W)) return false;
  n_ = patch.F / N_;
  c_ = patch.m1 / patch.W;
  Q_ = patch.m2 / patch.W - c_ * c_.transpose();
  k_ = kTorsionLever * std::sqrt(std::max(0.0, Q_.trace()));
  const Vector3d w = in_.nu.head<3>();
  u_ = in_.nu.tail<3>() + w.cross(c_);
  u_n_ = n_.dot(u_);
  w_n_ = n_.dot(w);
  const double d = material.damping;
  const SmoothRamp ramp = CalcSmoothRamp(1.0 - d * u_n_, 1.0);
  D_ = ramp.value;
  dD_ = ramp.slope;

  p_ = n_.cross(w);
  Qp_ = Q_ * p_;
  rocking_root_ = std::sqrt(1.0 + d * d * std::max(0.0, p_.dot(Qp_)));
  rock_ = -d / rocking_root_ * Qp_.cross(n_);

  s_t_ = u_ - u_n_ * n_;
  s_ << s_t_, k_ * w_n_;
  const double mu = material.friction;
  if (material.stick_distance > 0.0) {
    const Vector3d bend = in_.bristle.head<3>();
    base_ << bend - n_.dot(bend) * n_, in_.bristle(3);
    step_ = CalcBristleStep(base_, s_, in_.h, material.stick_distance);
    tau_ = -mu / material.stick_distance * step_.z;
    const SmoothRamp fade = CalcSmoothStep(N_ / in_.N_light);
    fade_ = fade.value;
    dfade_ = fade.slope / in_.N_light;
    bristle_ = fade_ * step_.z;
  } else {
    slow_ = std::sqrt(s_.squaredNorm() + material.slip_speed * material.slip_speed);
    tau_ = -mu / slow_ * s_;
    bristle_.setZero();
  }

  roll_.setZero();
  if (in_.rolling_radius > 0.0) {
    w_t_ = w - w_n_ * n_;
    const double slow = material.slip_speed / in_.rolling_radius;
    rolling_root_ = std::sqrt(w_t_.squaredNorm() + slow * slow);
    roll_ = -material.rolling_resistance * in_.rolling_radius / rolling_root_ * w_t_;
  }

  const double N_d = D_ * N_;
  const Vector3d f = N_d * tau_.head<3>();
  wrench_.head<3>() = D_ * patch.M + c_.cross(f) + N_d * (k_ * tau_(3) * n_ + rock_ + roll_);
  wrench_.tail<3>() = D_ * patch.F + f;
  return true;
}

void PatchLaw::PullBack(const Vector6d& bar_wrench, const Bristle& bar_bristle, PatchCotangent* bar_patch,
                        Vector6d* bar_nu, Bristle* bar_previous) const {
  const ContactMaterial& material = *in_.material;
  const double d = material.damping;
  const double mu = material.friction;
  const Vector3d w = in_.nu.head<3>();
  const Vector3d bar_M = bar_wrench.head<3>();
  const double N_d = D_ * N_;

  // The wrench.
  bar_patch->M += D_ * bar_M;
  bar_patch->F += D_ * bar_wrench.tail<3>();
  double bar_D = patch_->M.dot(bar_M) + patch_->F.dot(bar_wrench.tail<3>());
  const Vector3d bar_f = bar_wrench.tail<3>() + bar_M.cross(c_);
  Vector3d bar_c = N_d * tau_.head<3>().cross(bar_M);
  const double twist = k_ * tau_(3);
  const double bar_N_d = tau_.head<3>().dot(bar_f) + (twist * n_ + rock_ + roll_).dot(bar_M);
  Bristle bar_tau;
  bar_tau << N_d * bar_f, N_d * k_ * n_.dot(bar_M);
  double bar_k = N_d * tau_(3) * n_.dot(bar_M);
  Vector3d bar_n = N_d * twist * bar_M;
  const Vector3d bar_rock = N_d * bar_M;
  Vector3d bar_w = Vector3d::Zero();
  double bar_w_n = 0.0;
  double bar_N = D_ * bar_N_d;
  bar_D += N_ * bar_N_d;

  if (in_.rolling_radius > 0.0) {
    // roll = g w_t/root
    const double g = -material.rolling_resistance * in_.rolling_radius / rolling_root_;
    const Vector3d bar_roll = N_d * bar_M;
    const Vector3d bar_w_t = g * (bar_roll - w_t_ * (w_t_.dot(bar_roll) / (rolling_root_ * rolling_root_)));
    bar_w += bar_w_t;
    bar_w_n -= n_.dot(bar_w_t);
    bar_n -= w_n_ * bar_w_t;
  }

  // Friction.
  Bristle bar_s = Bristle::Zero();
  if (material.stick_distance > 0.0) {
    const Bristle bar_z = -mu / material.stick_distance * bar_tau + fade_ * bar_bristle;
    bar_N += dfade_ * step_.z.dot(bar_bristle);
    Bristle bar_base = Bristle::Zero();
    PullBackBristleStep(step_, s_, bar_z, &bar_base, &bar_s);
    const Vector3d bend = in_.bristle.head<3>();
    const Vector3d bar_bend = bar_base.head<3>();
    bar_previous->head<3>() += bar_bend - n_.dot(bar_bend) * n_;
    (*bar_previous)(3) += bar_base(3);
    bar_n -= n_.dot(bar_bend) * bend + n_.dot(bend) * bar_bend;
  } else {
    bar_s = -mu / slow_ * (bar_tau - s_ * (s_.dot(bar_tau) / (slow_ * slow_)));
  }
  const Vector3d bar_s_t = bar_s.head<3>();
  bar_k += w_n_ * bar_s(3);
  bar_w_n += k_ * bar_s(3);
  Vector3d bar_u = bar_s_t;
  double bar_u_n = -n_.dot(bar_s_t);
  bar_n -= u_n_ * bar_s_t;

  // Rocking: rock = −d/root Qp × n, root² = 1 + d² p·Qp.
  if (d > 0.0) {
    const Vector3d bar_Qp_by_force = -d / rocking_root_ * n_.cross(bar_rock);
    const double bar_pQp = -0.5 * d * d * rock_.dot(bar_rock) / (rocking_root_ * rocking_root_);
    const Vector3d bar_Qp = bar_Qp_by_force + bar_pQp * p_;
    bar_n += -d / rocking_root_ * bar_rock.cross(Qp_);
    const Vector3d bar_p = Q_ * bar_Qp + bar_pQp * Qp_;
    const Matrix3d bar_Q = bar_Qp * p_.transpose();
    bar_patch->m2 += 0.5 / patch_->W * (bar_Q + bar_Q.transpose());
    bar_patch->W -= bar_Qp.dot(patch_->m2 * p_) / (patch_->W * patch_->W);
    bar_c -= (bar_Q + bar_Q.transpose()) * c_;
    bar_n += w.cross(bar_p);
    bar_w += bar_p.cross(n_);
  }
  // Damping.
  bar_u_n -= d * dD_ * bar_D;
  bar_u += bar_u_n * n_;
  bar_n += bar_u_n * u_;
  bar_n += bar_w_n * w;
  bar_w += bar_w_n * n_;
  // u = v0 + w × c
  bar_w += c_.cross(bar_u);
  bar_c += bar_u.cross(w);
  bar_nu->head<3>() += bar_w;
  bar_nu->tail<3>() += bar_u;
  // k = lever √tr Q
  if (k_ > 0.0) {
    const double bar_trace = bar_k * kTorsionLever * kTorsionLever / (2.0 * k_);
    bar_patch->m2.diagonal().array() += bar_trace / patch_->W;
    bar_patch->W -= bar_trace * patch_->m2.trace() / (patch_->W * patch_->W);
    bar_c -= 2.0 * bar_trace * c_;
  }
  bar_patch->m1 += bar_c / patch_->W;
  bar_patch->W -= bar_c.dot(c_) / patch_->W;
  bar_patch->F += bar_N * n_ + (bar_n - n_.dot(bar_n) * n_) / N_;
}

}  // namespace knap
