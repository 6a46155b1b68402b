#include "sim/gradient/adjoint.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "sim/math/check.h"

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

// What a loss puts on a body in the world, as a cotangent of the body's perturbation.
void AddStateCotangent(const StateCotangent& at, const BodyKinematics& kin, BodyCotangent* bar) {
  const Matrix3d R_BW = kin.X_WB.R.transpose();
  const Vector3d bar_v = R_BW * at.v_W;
  const Vector3d bar_w = R_BW * at.w_W;
  bar->eta.tail<3>() += R_BW * at.p_W;
  bar->eta.head<3>() += R_BW * at.r_W + kin.V.tail<3>().cross(bar_v) + kin.V.head<3>().cross(bar_w);
  bar->V.tail<3>() += bar_v;
  bar->V.head<3>() += bar_w;
}

// What the loss sees of the parameters, less what the steps' equations do.
void SubtractSteps(const ParameterCotangents& loss, const ParameterCotangents& steps, TrajectoryGradient* out) {
  out->gravity = loss.gravity - steps.gravity;
  out->finite = out->finite && out->gravity.allFinite() && out->controls.allFinite();
  out->bodies = loss.bodies;
  for (std::size_t i = 0; i < out->bodies.size(); ++i) {
    BodyParameterCotangent& b = out->bodies[i];
    const BodyParameterCotangent& s = steps.bodies[i];
    b.placement -= s.placement;
    b.axis -= s.axis;
    b.mass -= s.mass;
    b.first_moment -= s.first_moment;
    b.inertia -= s.inertia;
    b.law.damping -= s.law.damping;
    b.law.stiffness -= s.law.stiffness;
    b.law.rest -= s.law.rest;
    out->finite = out->finite && b.placement.allFinite() && b.inertia.allFinite();
  }
}

}  // namespace

TrajectoryGradient SweepAdjoint(const Trajectory& trajectory, const std::vector<StateCotangent>& cotangents,
                                Dynamics* dynamics, ContactModel* contacts, Feedback* feedback) {
  KNAP_CHECK(trajectory.certificate.converged, "adjoint of a trajectory that did not converge");
  const Tree& tree = dynamics->tree();
  const int nv = tree.nv();
  TrajectoryGradient out;
  ContactModel::Cotangents by_contact = contacts->MakeCotangents(tree.size());
  std::vector<Bristle> bar_bristles;  // of state k
  Bristles previous;
  // Of state k; `before` of k−1.
  VectorXd bar_pose = VectorXd::Zero(nv);
  VectorXd bar_xi = VectorXd::Zero(nv);
  VectorXd bar_v = VectorXd::Zero(nv);
  VectorXd bar_v_before = VectorXd::Zero(nv);
  VectorXd g(nv);
  VectorXd lambda(nv);
  VectorXd q(tree.nq());
  VectorXd v(nv);
  VectorXd vdot(nv);
  VectorXd xi(nv);
  VectorXd r(nv);
  VectorXd magnitude(nv);
  JointCotangents by_residual{VectorXd::Zero(nv), VectorXd::Zero(nv), VectorXd::Zero(nv)};
  JointCotangents by_loss = by_residual;
  std::vector<BodyCotangent> bodies(tree.size());
  ParameterCotangents loss_parameters(tree);
  ParameterCotangents step_parameters(tree);
  const ControlSequence& controls = trajectory.controls;
  const bool controlled = controls.values.size() > 0;
  out.controls.setZero(controls.values.rows(), controls.values.cols());
  dynamics->controls().setZero();
  int step = std::max(trajectory.whole_steps() - 1, 0);  // the whole step that led to state k
  // The interval that begins next, on the way back: the last one that acted, at first.
  int interval = feedback == nullptr || trajectory.whole_steps() == 0
                     ? -1
                     : (trajectory.whole_steps() - 1) / controls.steps_per_interval;
  FeedbackCotangents by_feedback{VectorXd::Zero(nv), VectorXd::Zero(nv), {}};
  auto next = cotangents.rbegin();
  constexpr double kEps = std::numeric_limits<double>::epsilon();
  double rounding_squared = 0.0;

  for (int k = trajectory.size() - 1; k >= 0; --k) {
    q = trajectory.q(k);
    v = trajectory.v(k);
    vdot = trajectory.vdot(k);
    xi = trajectory.xi(k);
    while (step > 0 && trajectory.state_of_step(step) >= k) --step;
    if (controlled) dynamics->controls() = controls.values.col(controls.IntervalOfStep(step));
    dynamics->CalcKinematics(q, v, vdot, trajectory.time(k));
    by_feedback.bodies.clear();
    if (interval >= 0 && trajectory.state_of_step(interval * controls.steps_per_interval) == k) {
      by_feedback.pose.setZero();
      by_feedback.v.setZero();
      feedback->PullBack({interval, k, trajectory.time(k), q, v, dynamics->kinematics()}, out.controls.col(interval),
                         &by_feedback);
      bar_pose += by_feedback.pose;
      bar_v += by_feedback.v;
      --interval;
    }
    const bool is_watched = next != cotangents.rend() && next->state == k;
    if (is_watched || !by_feedback.bodies.empty()) {
      for (BodyCotangent& b : bodies) b = BodyCotangent{};
      for (; next != cotangents.rend() && next->state == k; ++next) {
        AddStateCotangent(*next, dynamics->kinematics()[next->body], &bodies[next->body]);
      }
      for (const StateCotangent& at : by_feedback.bodies) {
        AddStateCotangent(at, dynamics->kinematics()[at.body], &bodies[at.body]);
      }
      dynamics->PullBackKinematics(&bodies, &by_loss, &loss_parameters);
      bar_pose += by_loss.pose;
      bar_v += by_loss.v;
    }
    rounding_squared += (kEps * kEps) * bar_pose.squaredNorm();
    if (k == 0) break;

    const BdfCoefficients& c = trajectory.coefficients(k);
    trajectory.GetBristles(k - 1, &previous);
    contacts->BeginStep(c.h, previous);
    contacts->AddWrenches(dynamics);
    contacts->AddDerivatives(ContactDerivatives::kAll, dynamics);
    by_contact.previous.assign(previous.z.size(), Bristle::Zero());
    if (contacts->has_bristles()) {
      // What the next step's friction sees of this state.
      bar_bristles.resize(contacts->bristles().z.size(), Bristle::Zero());
      for (BodyCotangent& b : by_contact.bodies) b = BodyCotangent{};
      contacts->PullBackBristles(bar_bristles, &by_contact);
      dynamics->PullBackKinematics(&by_contact.bodies, &by_loss, &loss_parameters);
      bar_pose += by_loss.pose;
      bar_v += by_loss.v;
    }
    dynamics->CalcResidual(c.g0, &r, &magnitude);
    if (!dynamics->Factor(xi, c.c_v, c.g0 * c.c_v)) {
      out.solvable = false;
      break;
    }
    g = bar_xi + c.c_v * bar_v;
    AddRightJacobianTransposed(tree, xi, bar_pose, &g);
    dynamics->SolveTransposed(g, &lambda);
    const double left_by_newton = lambda.dot(r);
    rounding_squared += left_by_newton * left_by_newton + (kEps * kEps) * lambda.cwiseProduct(magnitude).squaredNorm();
    dynamics->PullBackResidual(lambda, &by_residual, &step_parameters);
    if (controlled) out.controls.col(controls.IntervalOfStep(step)) -= step_parameters.controls;
    step_parameters.controls.setZero();
    // r = … − f_ext, and the step's equation contributes −lambdaᵀ dr: the wrench's cotangent is +W.
    contacts->PullBackWrenches(dynamics->virtual_twists(), *dynamics, &by_contact);
    bar_bristles = by_contact.previous;

    bar_pose -= by_residual.pose;
    RotateBack(tree, xi, &bar_pose);
    bar_xi = -c.alpha * c.c_v * (bar_v - by_residual.v - c.g0 * by_residual.vdot);
    bar_v = bar_v_before - c.g1 * by_residual.vdot;
    bar_v_before = -c.g2 * by_residual.vdot;
  }
  out.vertices = std::move(by_contact.vertices);
  out.grips = std::move(by_contact.grips);
  out.loss_rounding = std::sqrt(rounding_squared);
  out.pose0 = bar_pose;
  out.v0 = bar_v;
  out.finite = out.pose0.allFinite() && out.v0.allFinite();
  SubtractSteps(loss_parameters, step_parameters, &out);
  for (const Eigen::Matrix3Xd& vertices : out.vertices) out.finite = out.finite && vertices.allFinite();
  return out;
}

}  // namespace knap
