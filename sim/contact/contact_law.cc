#include "sim/contact/contact_law.h"

#include <cmath>

#include "sim/math/smooth_ramp.h"

namespace knap {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

constexpr double kLinearShare = 0.85;  // y0 of the header

struct Saturation {
  double value;
  double slope;
};

Saturation CalcSaturation(double y) {
  if (y <= kLinearShare) return {y, 1.0};
  const double t = (y - kLinearShare) / (1.0 - kLinearShare);
  const double t4 = t * t * t * t;
  const double root = std::sqrt(std::sqrt(1.0 + t4));
  return {kLinearShare + (1.0 - kLinearShare) * t / root, 1.0 / (root * (1.0 + t4))};
}

// A C² step from 0 at x ≤ 0 to 1 at x ≥ 1.
Saturation CalcSmoothStep(double x) {
  if (x <= 0.0) return {0.0, 0.0};
  if (x >= 1.0) return {1.0, 0.0};
  return {x * x * x * (10.0 + x * (-15.0 + 6.0 * x)), 30.0 * x * x * (1.0 - x) * (1.0 - x)};
}

}  // namespace

PointForce CalcPointForce(const ContactMaterial& material, double N_e, double N_light, const Vector3d& n,
                          const Vector3d& u, const Vector3d& z_previous, double h, PointForceJacobian* jacobian) {
  PointForce out;
  const double n_u = n.dot(u);
  const SmoothRamp ramp = CalcSmoothRamp(1.0 - material.damping * n_u, 1.0);
  out.N = N_e * ramp.value;
  const Vector3d s = u - n_u * n;
  const double mu = material.friction;
  Vector3d tau;
  // d tau/d(slip-like vector), where that vector is s or z.
  Matrix3d dtau;
  const bool has_bristle = material.stick_distance > 0.0;
  double n_z = 0.0;
  Saturation fade{};
  Vector3d q = Vector3d::Zero();
  Matrix3d dq;
  if (has_bristle) {
    const double z_s = material.stick_distance;
    n_z = n.dot(z_previous);
    const Vector3d z = z_previous - n_z * n + h * s;
    const double length = z.norm();
    const Saturation sigma = CalcSaturation(length / z_s);
    const double ratio = length <= kLinearShare * z_s ? 1.0 : sigma.value * z_s / length;
    q = ratio * z;
    tau = -mu / z_s * q;
    fade = CalcSmoothStep(N_e / N_light);
    out.bristle = fade.value * q;
    if (jacobian != nullptr) {
      dq = ratio * Matrix3d::Identity();
      if (length > kLinearShare * z_s) dq += ((sigma.slope - ratio) / (length * length)) * z * z.transpose();
      dtau = -mu / z_s * dq;
    }
  } else {
    const double norm = std::sqrt(s.squaredNorm() + material.slip_speed * material.slip_speed);
    tau = -mu / norm * s;
    if (jacobian != nullptr) dtau = -mu / norm * (Matrix3d::Identity() - s * s.transpose() / (norm * norm));
  }
  const Vector3d direction = n + tau;
  out.f = out.N * direction;
  if (jacobian == nullptr) return out;

  PointForceJacobian& j = *jacobian;
  const double damped = -material.damping * N_e * ramp.slope;  // dN/d(n·u)
  j.dN_dNe = ramp.value;
  j.dN_dn = damped * u;
  j.dN_du = damped * n;
  j.df_dNe = ramp.value * direction;
  const Matrix3d tangent = Matrix3d::Identity() - n * n.transpose();
  Matrix3d ds_dn = -n * u.transpose();
  ds_dn.diagonal().array() -= n_u;
  Matrix3d dtau_dn;
  Matrix3d dtau_du;
  if (has_bristle) {
    Matrix3d dz_dn = h * ds_dn - n * z_previous.transpose();
    dz_dn.diagonal().array() -= n_z;
    dtau_dn = dtau * dz_dn;
    dtau_du = h * dtau * tangent;
    j.df_dz = out.N * dtau * tangent;
    j.dq_dNe = fade.slope / N_light * q;
    j.dq_dn = fade.value * dq * dz_dn;
    j.dq_du = fade.value * h * dq * tangent;
    j.dq_dz = fade.value * dq * tangent;
  } else {
    dtau_dn = dtau * ds_dn;
    dtau_du = dtau * tangent;
    j.df_dz.setZero();
    j.dq_dNe.setZero();
    j.dq_dn.setZero();
    j.dq_du.setZero();
    j.dq_dz.setZero();
  }
  j.df_dn = direction * j.dN_dn.transpose() + out.N * dtau_dn;
  j.df_dn.diagonal().array() += out.N;
  j.df_du = direction * j.dN_du.transpose() + out.N * dtau_du;
  return out;
}

RollingMoment CalcRollingMoment(const ContactMaterial& material, double r, double N, const Vector3d& n,
                                const Vector3d& w) {
  RollingMoment out;
  const double n_w = n.dot(w);
  const Vector3d w_t = w - n_w * n;
  const double slow = material.slip_speed / r;
  const double rho = std::sqrt(w_t.squaredNorm() + slow * slow);
  const double c = -material.rolling_resistance * r / rho;
  out.dm_dN = c * w_t;
  out.m = N * out.dm_dN;
  const Matrix3d by_wt = N * c * (Matrix3d::Identity() - w_t * w_t.transpose() / (rho * rho));
  out.dm_dw = by_wt * (Matrix3d::Identity() - n * n.transpose());
  out.dm_dn = -by_wt * (n_w * Matrix3d::Identity() + n * w.transpose());
  return out;
}

}  // namespace knap
