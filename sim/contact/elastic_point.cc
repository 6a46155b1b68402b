#include "sim/contact/elastic_point.h"

#include <cmath>
#include <numbers>

#include "sim/math/smooth_ramp.h"

namespace knap {

using Eigen::Matrix3d;
using Eigen::Vector3d;

bool CalcFieldPoint(const ShapeField& field, const Vector3d& c, double k, double rho, bool want_jacobian,
                    ElasticPoint* out) {
  FieldValue value;
  if (!field.Evaluate(c, &value)) return false;
  const double slope = value.gradient.norm();
  const SmoothRamp depth = CalcSmoothRamp(-value.phi, kOnsetDepth);
  if (!(slope > 0.0) || !(depth.value > 0.0)) return false;
  out->n = value.gradient / slope;
  out->N = k * depth.value * slope;
  out->N_light = k * kLightDepth;
  out->l = -rho * out->n;
  if (!want_jacobian) return true;
  const Vector3d hessian_n = value.hessian * out->n;
  out->dN_dc = k * (depth.value * hessian_n - depth.slope * slope * value.gradient);
  out->dn_dc = (value.hessian - out->n * hessian_n.transpose()) / slope;
  out->dl_dc = -rho * out->dn_dc;
  return true;
}

void MeshIntegrals::Add(const SphereTriangleIntegrals& part, const Vector3d& n) {
  W += part.W;
  g += part.g;
  const SphereTriangleJacobian j = CalcSphereTriangleJacobian(part, n);
  geometry.dW_dc += j.dW_dc;
  geometry.dg_dc += j.dg_dc;
}

void CalcBallOnMesh(const MeshIntegrals& in, double k, double rho, ElasticPoint* out, IntegralJacobian* jacobian) {
  const double a2 = std::sqrt(2.0 * in.W / std::numbers::pi);
  const SmoothRamp depth = CalcSmoothRamp(a2 / (2.0 * rho), kOnsetDepth);
  const double g_norm = in.g.norm();
  out->n = in.g / g_norm;
  const double share = g_norm / (in.W * rho);
  out->N = k * depth.value * share;
  out->N_light = k * kLightDepth;
  out->l = -rho * out->n;
  if (jacobian == nullptr) return;
  jacobian->dN_dW = k * share * (depth.slope * a2 / (4.0 * rho) - depth.value) / in.W;
  jacobian->dN_dg = k * depth.value / (in.W * rho) * out->n;
  jacobian->dn_dg = (Matrix3d::Identity() - out->n * out->n.transpose()) / g_norm;
  jacobian->dl_dW.setZero();
  jacobian->dl_dg = -rho * jacobian->dn_dg;
}

void CalcSphereOnMesh(const MeshIntegrals& in, double modulus, double r, ElasticPoint* out,
                      IntegralJacobian* jacobian) {
  const double k = modulus / (2.0 * r * r);
  const double g_norm = in.g.norm();
  out->n = in.g / g_norm;
  out->N = k * g_norm;
  out->N_light = modulus * r * r * kLightDepth;
  out->l = -in.g / in.W;
  if (jacobian == nullptr) return;
  jacobian->dN_dW = 0.0;
  jacobian->dN_dg = k * out->n;
  jacobian->dn_dg = (Matrix3d::Identity() - out->n * out->n.transpose()) / g_norm;
  jacobian->dl_dW = in.g / (in.W * in.W);
  jacobian->dl_dg = -Matrix3d::Identity() / in.W;
}

void ChainIntegrals(const MeshIntegrals& in, const IntegralJacobian& j, ElasticPoint* out) {
  out->dN_dc = j.dN_dW * in.geometry.dW_dc.transpose() + in.geometry.dg_dc.transpose() * j.dN_dg;
  out->dn_dc = j.dn_dg * in.geometry.dg_dc;
  out->dl_dc = j.dl_dW * in.geometry.dW_dc + j.dl_dg * in.geometry.dg_dc;
}

}  // namespace knap
