#include "sim/contact/contact_law.h"

#include <cmath>

#include "sim/math/smooth_ramp.h"
#include "sim/math/so3.h"

namespace knap {

using Eigen::Matrix3d;
using Eigen::Vector3d;

PatchForce CalcPatchForce(const ContactMaterial& material, double r, double W, const Vector3d& g, const Vector3d& u,
                          const Vector3d& w, bool want_jacobian) {
  PatchForce out;
  const double k = material.stiffness / (2.0 * r * r);
  const double g_norm = g.norm();
  if (g_norm == 0.0) return out;
  const Vector3d n = g / g_norm;
  const Vector3d l = -g / W;
  const double n_u = n.dot(u);
  const SmoothRamp ramp = CalcSmoothRamp(1.0 - material.damping * n_u, 1.0);
  const double N_elastic = k * g_norm;
  const double N = N_elastic * ramp.value;
  const Vector3d s = u - n_u * n + w.cross(l);
  const double sigma = std::sqrt(s.squaredNorm() + material.slip_speed * material.slip_speed);
  const Vector3d t = -material.friction / sigma * s;  // friction per unit of normal force
  const double n_w = n.dot(w);
  const Vector3d w_t = w - n_w * n;
  const double slip_rate = material.slip_speed / r;
  const double rho = std::sqrt(w_t.squaredNorm() + slip_rate * slip_rate);
  const double c = -material.rolling_resistance * r / rho;
  const Vector3d f_t = N * t;
  out.f = N * n + f_t;
  out.m = l.cross(f_t) + N * c * w_t;
  if (!want_jacobian) return out;

  // Columns: 0 W, 1–3 g, 4–6 u, 7–9 w.
  using Matrix3x10 = Eigen::Matrix<double, 3, 10>;
  using Row10 = Eigen::Matrix<double, 1, 10>;
  const Matrix3d tangent = Matrix3d::Identity() - n * n.transpose();
  const Matrix3d dn_dg = tangent / g_norm;

  Row10 dN = Row10::Zero();
  const double damped = N_elastic * ramp.slope * -material.damping;  // dN/d(n·u)
  dN.segment<3>(1) = (ramp.value * k * n + damped * dn_dg * u).transpose();
  dN.segment<3>(4) = damped * n.transpose();

  Matrix3x10 dl = Matrix3x10::Zero();
  dl.col(0) = g / (W * W);
  dl.middleCols<3>(1) = -Matrix3d::Identity() / W;

  Matrix3x10 ds = Skew(w) * dl;
  ds.middleCols<3>(1) -= (n_u * Matrix3d::Identity() + n * u.transpose()) * dn_dg;
  ds.middleCols<3>(4) += tangent;
  ds.middleCols<3>(7) -= Skew(l);

  const Matrix3d dt_ds = -material.friction / sigma * (Matrix3d::Identity() - s * s.transpose() / (sigma * sigma));
  const Matrix3x10 df_t = t * dN + N * (dt_ds * ds);

  Matrix3x10 df = n * dN + df_t;
  df.middleCols<3>(1) += N * dn_dg;

  Matrix3x10 dw_t = Matrix3x10::Zero();
  dw_t.middleCols<3>(1) = -(n_w * Matrix3d::Identity() + n * w.transpose()) * dn_dg;
  dw_t.middleCols<3>(7) = tangent;
  const Matrix3d dr_dw_t = c * (Matrix3d::Identity() - w_t * w_t.transpose() / (rho * rho));

  const Matrix3x10 dm = Skew(l) * df_t - Skew(f_t) * dl + c * w_t * dN + N * (dr_dw_t * dw_t);
  out.jacobian.topRows<3>() = df;
  out.jacobian.bottomRows<3>() = dm;
  return out;
}

}  // namespace knap
