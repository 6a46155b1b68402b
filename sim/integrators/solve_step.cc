#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/integrators/simulate.h"

namespace knap {

namespace {

// Of the search with added inertia.
constexpr double kFirstAddedInertia = 10.0;
constexpr double kLeastAddedInertia = 1e-2;
constexpr double kMaxAddedInertia = 1e8;
constexpr int kMaxHeavySteps = 200;
// Beyond this a linearisation says nothing. And far out lie roots that are none: where everything has been thrown away,
// the residual is small beside the forces that did it. [rad, m]
constexpr double kLongestHeavyStep = 0.3;

}  // namespace

// Residual at xi_trial_; leaves q_, v_, vdot_, r_, scale_. Returns the scaled residual.
double Simulator::Evaluate(double time, const StepFormula& f, const Trajectory& trajectory) {
  const int k = trajectory.size() - 1;
  const int before = std::max(k - 1, 0);
  v_ = f.c_v * (xi_trial_ - f.alpha * trajectory.xi(k));
  if (f.e != 0.0) v_ -= (f.c_v * f.e) * trajectory.v(k);
  vdot_ = f.g0 * v_ + f.g1 * trajectory.v(k) + f.g2 * trajectory.v(before);
  if (f.g_a != 0.0) vdot_ += f.g_a * trajectory.vdot(k);
  q_ = trajectory.q(k);
  dynamics_->tree().AddIncrement(q_, xi_trial_, &q_);
  dynamics_->CalcKinematics(q_, v_, vdot_, time);
  contacts_->AddWrenches(dynamics_);
  dynamics_->CalcResidual(f.g0, &r_, &magnitude_);
  scale_.setZero();
  for (Eigen::Index row = 0; row < r_.size(); ++row) {
    double& joint_scale = scale_(joint_of_row_[row]);
    joint_scale = std::max(joint_scale, magnitude_(row));
  }
  double worst = 0.0;
  for (Eigen::Index row = 0; row < r_.size(); ++row) {
    scale_(row) = scale_(joint_of_row_[row]);
    if (!std::isfinite(r_(row))) return std::numeric_limits<double>::infinity();
    if (r_(row) != 0.0) worst = std::max(worst, std::abs(r_(row)) / scale_(row));
  }
  return worst;
}

// What the line search lowers: the sum of the rows' squares, each against its joint's scale before the step, so that
// growing forces do not hide a growing residual. A joint on which next to nothing acted has none yet: the trial's.
double Simulator::CalcMerit() const {
  double sum = 0.0;
  for (Eigen::Index row = 0; row < r_.size(); ++row) {
    const double scale = scale_now_(row) > 1e-6 * scale_(row) ? scale_now_(row) : scale_(row);
    if (r_(row) == 0.0) continue;
    const double share = r_(row) / scale;
    sum += share * share;
  }
  return sum;
}

bool Simulator::Solve(double time, const StepFormula& f, const SimulationOptions& options, Trajectory* trajectory) {
  const int k = trajectory->size() - 1;
  const int before = std::max(k - 1, 0);
  trajectory->GetBristles(k, &bristles_now_);
  if (f.zeta != 0.0) trajectory->GetBristles(before, &bristles_before_);
  CalcBristleBase(f, bristles_now_, bristles_before_, nullptr, &bristle_base_);
  contacts_->BeginStep(f.h_contact, bristle_base_);
  // Start where the predicted acceleration would lead.
  predictor_.Predict(time, &vdot_);
  v_ = (vdot_ - f.g1 * trajectory->v(k) - f.g2 * trajectory->v(before)) / f.g0;
  if (f.g_a != 0.0) v_ -= (f.g_a / f.g0) * trajectory->vdot(k);
  start_ = f.alpha * trajectory->xi(k) + v_ / f.c_v;
  if (f.e != 0.0) start_ += f.e * trajectory->v(k);
  xi_trial_ = start_;
  double scaled = Evaluate(time, f, *trajectory);
  if (!FindRoot(time, f, options, trajectory, &scaled)) {
    xi_trial_ = start_;
    scaled = Evaluate(time, f, *trajectory);
    if (!ComeNearWithAddedInertia(time, f, trajectory, &scaled)) return false;
    if (!FindRoot(time, f, options, trajectory, &scaled)) return false;
  }
  trajectory->certificate.worst_residual = std::max(trajectory->certificate.worst_residual, scaled);
  bristles_next_.bent = contacts_->bristles();
  CalcBristleRates(f, bristle_base_, &bristles_next_);
  trajectory->Append(time, f, q_, v_, xi_trial_, vdot_, bristles_next_);
  predictor_.Push(time, vdot_);
  return true;
}

bool Simulator::IsWithinATurn() const {
  for (const TreeBody& body : dynamics_->tree().bodies()) {
    const bool turns = body.joint == JointType::kRevolute || body.joint == JointType::kBall;
    if (turns && !(xi_trial_.segment(body.v_start, CountDof(body.joint)).norm() < kLongestTurn)) return false;
  }
  return true;
}

// Newton with a backtracking line search, from xi_trial_.
bool Simulator::FindRoot(double time, const StepFormula& f, const SimulationOptions& options, Trajectory* trajectory,
                         double* scaled) {
  for (int iteration = 0;; ++iteration) {
    if (!std::isfinite(*scaled)) return false;
    if (*scaled <= options.newton_tolerance) return IsWithinATurn();
    if (iteration == options.newton_max_iterations) return false;
    if (!CalcNewtonStep(f, 0.0, trajectory)) return false;
    scale_now_ = scale_;
    const double merit_now = CalcMerit();
    const double scaled_now = *scaled;
    double length = 1.0;
    while (true) {
      xi_trial_ = xi_ - length * dx_;
      *scaled = Evaluate(time, f, *trajectory);
      if (*scaled <= options.newton_tolerance) break;
      if (std::isfinite(*scaled) && CalcMerit() <= (1.0 - 1e-4 * length) * merit_now) break;
      length *= 0.5;
      if (length >= 1e-4) continue;
      // Nothing along the step is better. Near the rounding floor that is an end, elsewhere a failure.
      if (scaled_now > kRoundingFloor) return false;
      xi_trial_ = xi_;
      *scaled = Evaluate(time, f, *trajectory);
      return IsWithinATurn();
    }
  }
}

// Pseudo-transient continuation: with the inertia in Newton's matrix, but not in r, a multiple a of itself, steps are
// implicit ones along xi' = −M⁻¹ r, each 1/a long, and 1/a grows as the residual falls [Kelley & Keyes 1998]. The flow
// runs past where r is least without being zero, which holds a line search up, and, unlike Newton, away from what is
// in unstable equilibrium.
bool Simulator::ComeNearWithAddedInertia(double time, const StepFormula& f, Trajectory* trajectory, double* scaled) {
  double added = kFirstAddedInertia;
  scale_now_ = scale_;
  double merit = CalcMerit();
  for (int i = 0; i < kMaxHeavySteps && std::isfinite(*scaled); ++i) {
    if (added < kLeastAddedInertia || *scaled <= kRoundingFloor) return true;
    if (added > kMaxAddedInertia || !CalcNewtonStep(f, added, trajectory)) return false;
    const bool too_long = !(dx_.lpNorm<Eigen::Infinity>() <= kLongestHeavyStep);
    xi_trial_ = xi_;
    if (!too_long) xi_trial_ -= dx_;
    *scaled = Evaluate(time, f, *trajectory);
    if (too_long) {
      added *= 10.0;
      continue;
    }
    const double merit_now = CalcMerit();
    added *= std::clamp(std::sqrt(merit_now / merit), 0.25, 10.0);
    merit = merit_now;
  }
  return false;
}

// xi_ and dx_ at xi_trial_, which was evaluated last.
bool Simulator::CalcNewtonStep(const StepFormula& f, double added_inertia, Trajectory* trajectory) {
  ++trajectory->certificate.newton_iterations;
  xi_ = xi_trial_;
  contacts_->AddDerivatives(ContactDerivatives::kSolve, dynamics_);
  if (!dynamics_->Factor(xi_, f.c_v, (1.0 + added_inertia) * f.g0 * f.c_v)) return false;
  dynamics_->Solve(r_, &dx_);
  return true;
}

}  // namespace knap
