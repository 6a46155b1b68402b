#include "sim/gradient/solve_pull_back.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "sim/math/so3.h"

namespace knap {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

// Exp(xi) on each joint's tangent: the transpose of how an earlier pose error is seen after the increment.
void RotateBack(const Tree& tree, const VectorXd& xi, VectorXd* tangent) {
  for (const TreeBody& body : tree.bodies()) {
    if (body.joint != JointType::kBall) continue;
    const Vector3d turned = ExpSo3(xi.segment<3>(body.v_start)) * tangent->segment<3>(body.v_start);
    tangent->segment<3>(body.v_start) = turned;
  }
}

void AddRightJacobianTransposed(const Tree& tree, const VectorXd& xi, const VectorXd& pose, VectorXd* g) {
  for (const TreeBody& body : tree.bodies()) {
    const int n = CountDof(body.joint);
    if (body.joint == JointType::kBall) {
      const Matrix3d Jr = RightJacobianSo3(xi.segment<3>(body.v_start));
      g->segment<3>(body.v_start) += Jr.transpose() * pose.segment<3>(body.v_start);
    } else {
      for (int k = 0; k < n; ++k) (*g)(body.v_start + k) += pose(body.v_start + k);
    }
  }
}

}  // namespace

void StateBars::Add(const StateBars& other) {
  pose += other.pose;
  xi += other.xi;
  v += other.v;
  vdot += other.vdot;
  v_before += other.v_before;
  const auto add = [](const std::vector<Bristle>& from, std::vector<Bristle>* to) {
    to->resize(std::max(to->size(), from.size()), Bristle::Zero());
    for (std::size_t i = 0; i < from.size(); ++i) (*to)[i] += from[i];
  };
  add(other.bristles.bent, &bristles.bent);
  add(other.bristles.rate, &bristles.rate);
  add(other.bristles_before.bent, &bristles_before.bent);
  add(other.bristles_before.rate, &bristles_before.rate);
}

SolvePullBack::SolvePullBack(const Trajectory& trajectory, Dynamics* dynamics, ContactModel* contacts)
    : trajectory_(trajectory),
      dynamics_(dynamics),
      contacts_(contacts),
      step_(std::max(trajectory.whole_steps() - 1, 0)),
      earlier_(dynamics->tree().nv()),
      by_loss_(dynamics->tree()),
      by_solves_(dynamics->tree()),
      by_contact_(contacts->MakeCotangents(dynamics->tree().size())) {
  const int nv = dynamics->tree().nv();
  for (VectorXd* x : {&v_, &vdot_, &xi_, &r_, &magnitude_, &g_, &lambda_, &joints_.pose, &joints_.v, &joints_.vdot}) {
    x->setZero(nv);
  }
  q_.setZero(dynamics->tree().nq());
  bar_controls_.setZero(trajectory.controls.values.rows(), trajectory.controls.values.cols());
  dynamics_->controls().setZero();
}

void SolvePullBack::FindStep() {
  while (step_ > 0 && trajectory_.state_of_step(step_) >= k_) --step_;
  while (step_ + 1 < trajectory_.whole_steps() && trajectory_.state_of_step(step_ + 1) < k_) ++step_;
}

void SolvePullBack::LoadState(int k) {
  k_ = k;
  FindStep();
  q_ = trajectory_.q(k);
  v_ = trajectory_.v(k);
  vdot_ = trajectory_.vdot(k);
  xi_ = trajectory_.xi(k);
  const ControlSequence& controls = trajectory_.controls;
  if (controls.values.size() > 0) dynamics_->controls() = controls.values.col(controls.IntervalOfStep(step_));
  dynamics_->CalcKinematics(q_, v_, vdot_, trajectory_.time(k));
}

bool SolvePullBack::LoadSolve() {
  const StepFormula& f = trajectory_.formula(k_);
  trajectory_.GetBristles(k_, &next_);
  trajectory_.GetBristles(k_ - 1, &now_);
  if (f.zeta != 0.0) trajectory_.GetBristles(k_ - 2, &before_);
  // With all that came to touch, so that what their base does is known.
  CalcBristleBase(f, now_, before_, &next_.bent, &base_);
  contacts_->BeginStep(f.h_contact, base_);
  contacts_->AddWrenches(dynamics_);
  contacts_->AddDerivatives(ContactDerivatives::kAll, dynamics_);
  dynamics_->CalcResidual(f.g0, &r_, &magnitude_);
  return dynamics_->Factor(xi_, f.c_v, f.g0 * f.c_v);
}

double SolvePullBack::AddBodies(std::vector<BodyCotangent>* bodies, StateBars* bars) {
  by_loss_.time = 0.0;
  dynamics_->PullBackKinematics(bodies, &joints_, &by_loss_);
  bars->pose += joints_.pose;
  bars->v += joints_.v;
  return by_loss_.time;
}

void SolvePullBack::AddForce(int contact, const Vector3d& bar_f_W) {
  bar_forces_.resize(contacts_->contacts().size(), Vector3d::Zero());
  bar_forces_[static_cast<std::size_t>(contact)] += bar_f_W;
}

void SolvePullBack::PullBackStart(StateBars* bars) {
  if (bar_forces_.empty()) return;
  contacts_->BeginStep(0.0, {});
  contacts_->AddWrenches(dynamics_);
  contacts_->AddDerivatives(ContactDerivatives::kAll, dynamics_);
  by_contact_.previous.clear();
  for (BodyCotangent& b : by_contact_.bodies) b = BodyCotangent{};
  contacts_->PullBackOutcome(std::vector<Bristle>(contacts_->bristles().z.size(), Bristle::Zero()), bar_forces_,
                             *dynamics_, &by_contact_);
  AddBodies(&by_contact_.bodies, bars);
  // What is left of the pull-back: the vertices.
  contacts_->PullBackWrenches(std::vector<Vector6d>(by_contact_.bodies.size(), Vector6d::Zero()), *dynamics_,
                              &by_contact_);
  bar_forces_.clear();
}

SolvePullBack::Result SolvePullBack::PullBack(StateBars* bars) {
  const Tree& tree = dynamics_->tree();
  const StepFormula& f = trajectory_.formula(k_);
  Result out;
  by_contact_.previous.assign(base_.z.size(), Bristle::Zero());
  bar_base_.assign(base_.z.size(), Bristle::Zero());
  if (contacts_->has_bristles()) {
    // No solve has looked at the last state.
    bars->bristles.bent.resize(next_.bent.z.size(), Bristle::Zero());
    bars->bristles.rate.resize(next_.bent.z.size(), Bristle::Zero());
    for (int i = 0; i < next_.bent.size(); ++i) out.by_step -= bars->bristles.rate[i].dot(next_.rate[i]);
    PullBackBristleRates(f, base_, next_, &bars->bristles, &bar_base_);
  }
  if (contacts_->has_bristles() || !bar_forces_.empty()) {
    for (BodyCotangent& b : by_contact_.bodies) b = BodyCotangent{};
    contacts_->PullBackOutcome(bars->bristles.bent, bar_forces_, *dynamics_, &by_contact_);
    out.by_time += AddBodies(&by_contact_.bodies, bars);
    bar_forces_.clear();
  }
  g_ = bars->xi + f.c_v * (bars->v + f.g0 * bars->vdot);
  AddRightJacobianTransposed(tree, xi_, bars->pose, &g_);
  dynamics_->SolveTransposed(g_, &lambda_);
  by_solves_.time = 0.0;
  by_solves_.controls.setZero();
  dynamics_->PullBackResidual(lambda_, &joints_, &by_solves_);
  out.by_time -= by_solves_.time;
  const ControlSequence& controls = trajectory_.controls;
  if (controls.values.size() > 0) bar_controls_.col(controls.IntervalOfStep(step_)) -= by_solves_.controls;
  // r = … − f_ext, and the solve's equation contributes −lambdaᵀ dr: the wrench's cotangent is +W.
  contacts_->PullBackWrenches(dynamics_->virtual_twists(), *dynamics_, &by_contact_);

  const VectorXd A = bars->vdot - joints_.vdot;
  const VectorXd B = bars->v - joints_.v + f.g0 * A;
  out.by_step -=
      f.c_v * B.dot(xi_ - f.alpha * trajectory_.xi(k_ - 1)) + A.dot(vdot_ - f.g_a * trajectory_.vdot(k_ - 1));
  if (contacts_->has_bristles()) {
    std::vector<Bristle>& by_contact = by_contact_.previous;
    std::size_t n = 0;
    for (std::size_t i = 0; i < base_.z.size(); ++i) {
      while (n < next_.bent.id.size() && next_.bent.id[n] < base_.id[i]) ++n;
      if (n < next_.bent.id.size() && next_.bent.id[n] == base_.id[i]) {
        out.by_step += f.h_contact * by_contact[i].dot(next_.rate[n]);
      }
      bar_base_[i] += by_contact[i];
    }
    BristleCotangents& bar_now = earlier_.bristles;
    bar_now = bars->bristles_before;
    bar_now.bent.resize(now_.bent.z.size(), Bristle::Zero());
    bar_now.rate.resize(now_.bent.z.size(), Bristle::Zero());
    earlier_.bristles_before.Reset(before_.bent.size());
    std::size_t base = 0;
    for (int i = 0; i < now_.bent.size(); ++i) {
      while (base_.id[base] < now_.bent.id[i]) ++base;
      out.by_step += f.e * bar_base_[base].dot(now_.rate[i]);
    }
    PullBackBristleBase(f, base_, bar_base_, now_, before_, &bar_now, &earlier_.bristles_before);
    if (f.zeta == 0.0) earlier_.bristles_before.Reset(0);
    std::swap(bars->bristles, bar_now);
    std::swap(bars->bristles_before, earlier_.bristles_before);
  }
  bars->pose -= joints_.pose;
  RotateBack(tree, xi_, &bars->pose);
  bars->xi = (-f.alpha * f.c_v) * B;
  bars->v = bars->v_before + f.g1 * A - (f.e * f.c_v) * B;
  bars->v_before = f.g2 * A;
  bars->vdot = f.g_a * A;
  out.by_step /= f.step;
  return out;
}

double SolvePullBack::CalcRoundingSquared() const {
  constexpr double kEps = std::numeric_limits<double>::epsilon();
  const double left_by_newton = lambda_.dot(r_);
  return left_by_newton * left_by_newton + (kEps * kEps) * lambda_.cwiseProduct(magnitude_).squaredNorm();
}

}  // namespace knap
