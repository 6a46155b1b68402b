#include "sim/multibody/joint_forces.h"

#include <cmath>

#include "sim/math/smooth_ramp.h"
#include "sim/math/so3.h"

namespace knap {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

namespace {

// The turn from the rest orientation to the present one, in the moving frame.
Quaterniond CalcTurn(const JointLaw& law, const double* q) {
  return ExpSo3(law.rest).conjugate() * Quaterniond(Eigen::Map<const Eigen::Vector4d>(q));
}

// Of −2 w e (w, e: parts of the turn) in the tangent: dw = −e·φ/2, de = (w φ + e × φ)/2.
Matrix3d CalcTurnStiffness(const Quaterniond& turn) {
  const Vector3d e = turn.vec();
  const double w = turn.w();
  return e * e.transpose() - w * w * Matrix3d::Identity() - w * Skew(e);
}

}  // namespace

void AddDamping(const JointLaw& law, int dof, const double* v, JointForce* force) {
  for (int k = 0; k < dof; ++k) {
    const double tau = -law.damping * v[k];
    force->tau(k) += tau;
    force->magnitude(k) += std::abs(tau);
    force->by_v(k) -= law.damping;
  }
}

void AddSpring(const JointLaw& law, int dof, const double* q, JointForce* force) {
  for (int k = 0; k < dof; ++k) {
    const double tau = -law.stiffness * (q[k] - law.rest(k));
    force->tau(k) += tau;
    force->magnitude(k) += law.stiffness * (std::abs(q[k]) + std::abs(law.rest(k)));  // what cancels leaves rounding
    force->by_pose(k, k) -= law.stiffness;
  }
}

void AddBallSpring(const JointLaw& law, const double* q, JointForce* force) {
  const Quaterniond turn = CalcTurn(law, q);
  force->tau -= 2.0 * law.stiffness * turn.w() * turn.vec();
  force->magnitude.array() += law.stiffness;
  force->by_pose += law.stiffness * CalcTurnStiffness(turn);
}

void AddLimit(const JointLimit& limit, double x, double v, JointForce* force) {
  if (x > limit.lower && x < limit.upper) return;
  const double side = x >= limit.upper ? 1.0 : -1.0;
  const double depth = x >= limit.upper ? x - limit.upper : limit.lower - x;
  const SmoothRamp elastic = CalcSmoothRamp(depth, limit.width);
  const SmoothRamp damped = CalcSmoothRamp(1.0 + limit.damping * side * v, 1.0);
  const double tau = limit.stiffness * elastic.value * damped.value;
  force->tau(0) -= side * tau;
  force->magnitude(0) += tau;
  force->by_pose(0, 0) -= limit.stiffness * elastic.slope * damped.value;
  force->by_v(0) -= limit.stiffness * elastic.value * damped.slope * limit.damping;
}

double AddActuator(const Actuator& actuator, double x, double v, double u, JointForce* force) {
  const int k = actuator.dof;
  if (actuator.kind == ActuatorKind::kForce) {
    force->tau(k) += actuator.effort_limit * u;
    force->magnitude(k) += actuator.effort_limit * std::abs(u);
    return actuator.effort_limit;
  }
  const double share = std::tanh((actuator.stiffness * (u - x) - actuator.damping * v) / actuator.effort_limit);
  const double slope = 1.0 - share * share;
  force->tau(k) += actuator.effort_limit * share;
  // The terms of e, as far as the saturation lets them through.
  force->magnitude(k) += slope * (actuator.stiffness * (std::abs(u) + std::abs(x)) + actuator.damping * std::abs(v)) +
                         actuator.effort_limit * std::abs(share);
  force->by_pose(k, k) -= slope * actuator.stiffness;
  force->by_v(k) -= slope * actuator.damping;
  return slope * actuator.stiffness;
}

void PullBackLaw(const JointLaw& law, int dof, const double* q, const double* v, const double* bar,
                 JointLawCotangent* out) {
  for (int k = 0; k < dof; ++k) {
    out->damping -= v[k] * bar[k];
    out->stiffness -= (q[k] - law.rest(k)) * bar[k];
    out->rest(k) += law.stiffness * bar[k];
  }
}

void PullBackBallLaw(const JointLaw& law, const double* q, const double* v, const double* bar, JointLawCotangent* out) {
  const Eigen::Map<const Vector3d> bar_tau(bar);
  out->damping -= Eigen::Map<const Vector3d>(v).dot(bar_tau);
  const Quaterniond turn = CalcTurn(law, q);
  out->stiffness -= 2.0 * turn.w() * turn.vec().dot(bar_tau);
  if (law.stiffness == 0.0) return;
  // A turn of the rest orientation by δ (in its own moving frame) turns the turn by −R(turn)ᵀ δ.
  const Vector3d bar_turn = law.stiffness * CalcTurnStiffness(turn).transpose() * bar_tau;
  out->rest -= RightJacobianSo3(law.rest).transpose() * (turn * bar_turn);
}

}  // namespace knap
