#include "sim/contact/sphere_triangle.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/math/check.h"

namespace knap {
namespace {

// The part of one edge's line inside the disc, in the coordinates of the header.
struct EdgeSpan {
  bool inside = false;  // a part of positive length lies in the disc
  double p = 0.0;       // signed distance of the edge from the foot, > 0 when the foot is on the inner side
  double q2 = 0.0;
  double t_begin = 0.0;  // of the edge's own ends
  double tau1 = 0.0;
  double tau2 = 0.0;

  EdgeSpan(const TriangleFrame& triangle, int k, const Eigen::Vector3d& foot, double a2) {
    const Eigen::Vector3d y = triangle.v[k] - foot;
    p = triangle.m[k].dot(y);
    q2 = a2 - p * p;
    t_begin = triangle.e[k].dot(y);
    if (q2 <= 0.0) return;
    const double q = std::sqrt(q2);
    tau1 = std::max(t_begin, -q);
    tau2 = std::min(t_begin + triangle.length[k], q);
    inside = tau2 > tau1;
  }
};

// ∫ t^k (q² − t²) dt over the span, k = 0, 1, 2.
struct EdgeMoments {
  double i0 = 0.0;
  double i1 = 0.0;
  double i2 = 0.0;
};

EdgeMoments CalcEdgeMoments(const EdgeSpan& s) {
  const double a = s.tau1;
  const double b = s.tau2;
  const double d1 = b - a;
  const double d2 = (b * b - a * a) / 2.0;
  const double d3 = (b * b * b - a * a * a) / 3.0;
  const double d4 = (b * b * b * b - a * a * a * a) / 4.0;
  const double d5 = (b * b * b * b * b - a * a * a * a * a) / 5.0;
  return {s.q2 * d1 - d3, s.q2 * d2 - d4, s.q2 * d3 - d5};
}

}  // namespace

TriangleFrame TriangleFrame::Make(const Eigen::Vector3d& v0, const Eigen::Vector3d& v1, const Eigen::Vector3d& v2) {
  TriangleFrame t;
  t.v = {v0, v1, v2};
  t.n = (v1 - v0).cross(v2 - v0).normalized();
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector3d edge = t.v[(k + 1) % 3] - t.v[k];
    t.length[k] = edge.norm();
    t.e[k] = edge / t.length[k];
    t.m[k] = t.e[k].cross(t.n);
  }
  return t;
}

SphereTriangleIntegrals CalcSphereTriangle(const TriangleFrame& triangle, const Eigen::Vector3d& c, double r) {
  SphereTriangleIntegrals out;
  out.h = triangle.n.dot(c - triangle.v[0]);
  const double a2 = r * r - out.h * out.h;
  if (a2 <= 0.0) return out;
  const Eigen::Vector3d foot = c - out.h * triangle.n;

  bool foot_inside = true;
  bool any_edge = false;
  const std::array<EdgeSpan, 3> spans{EdgeSpan(triangle, 0, foot, a2), EdgeSpan(triangle, 1, foot, a2),
                                      EdgeSpan(triangle, 2, foot, a2)};
  for (const EdgeSpan& s : spans) {
    // The disc is wholly beyond this edge.
    if (s.p < 0.0 && s.q2 <= 0.0) return out;
    foot_inside = foot_inside && s.p > 0.0;
    any_edge = any_edge || s.inside;
  }
  if (!foot_inside && !any_edge) return out;

  double angle = foot_inside ? 2.0 * std::numbers::pi : 0.0;  // Θ − Σ Δθ
  double polynomial_A0 = 0.0;
  double polynomial_W = 0.0;
  for (int k = 0; k < 3; ++k) {
    const EdgeSpan& s = spans[k];
    if (!s.inside) continue;
    const double p = s.p;
    const double d1 = s.tau2 - s.tau1;
    const double d3 = (s.tau2 * s.tau2 * s.tau2 - s.tau1 * s.tau1 * s.tau1) / 3.0;
    // The angle at which the foot sees the span. A foot on the edge counts as beyond it, as in foot_inside.
    angle -= std::atan2(p == 0.0 ? -0.0 : p * d1, p * p + s.tau1 * s.tau2);
    polynomial_A0 += p * d1;
    polynomial_W += p * ((0.5 * a2 - 0.25 * p * p) * d1 - 0.25 * d3);
    const EdgeMoments moments = CalcEdgeMoments(s);
    out.A1 -= 0.5 * moments.i0 * triangle.m[k];
    out.M1 -= 0.25 * (s.q2 * moments.i0 - moments.i2) * triangle.m[k];
    out.edge_moment += (p * moments.i0 * triangle.m[k] + moments.i1 * triangle.e[k]) * triangle.m[k].transpose();
  }
  out.A0 = 0.5 * (polynomial_A0 + a2 * angle);
  out.W = polynomial_W + 0.25 * a2 * a2 * angle;
  // Cancellation can leave rounding dust where the sphere only just touches; below it the force is zero anyway.
  if (!(out.W > 1e-15 * a2 * a2)) return SphereTriangleIntegrals{};
  out.g = out.W * out.h * triangle.n - out.M1;
  out.active = true;
  return out;
}

SphereTriangleIntegrals CalcSpherePlane(const Eigen::Vector3d& n, double h, double r) {
  SphereTriangleIntegrals out;
  out.h = h;
  const double a2 = r * r - h * h;
  if (a2 <= 0.0) return out;
  out.active = true;
  out.A0 = std::numbers::pi * a2;
  out.W = 0.5 * std::numbers::pi * a2 * a2;
  out.g = out.W * h * n;
  return out;
}

SphereTriangleJacobian CalcSphereTriangleJacobian(const SphereTriangleIntegrals& in, const Eigen::Vector3d& n) {
  SphereTriangleJacobian out;
  out.dW_dc = -2.0 * (in.A0 * in.h * n - in.A1).transpose();
  out.dg_dc = (in.W - 2.0 * in.A0 * in.h * in.h) * n * n.transpose() +
              2.0 * in.h * (n * in.A1.transpose() + in.A1 * n.transpose()) + in.edge_moment;
  return out;
}

std::array<Eigen::Vector3d, 3> PullBackSphereTriangle(const TriangleFrame& triangle, const SphereTriangleIntegrals& in,
                                                      const Eigen::Vector3d& c, double r, double bar_W,
                                                      const Eigen::Vector3d& bar_g) {
  KNAP_CHECK(in.active, "pull-back of an inactive triangle");
  const Eigen::Vector3d& n = triangle.n;
  const double h = in.h;
  const double a2 = r * r - h * h;
  const Eigen::Vector3d foot = c - h * n;
  const double gamma_n = bar_g.dot(n);
  std::array<Eigen::Vector3d, 3> bar_v{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};

  // Tangential part: boundary integrals of λ_k φ with φ = (q² − t²)(alpha + beta t) on the edge.
  std::array<double, 3> height{};  // of the triangle over edge k
  for (int k = 0; k < 3; ++k) {
    height[k] = triangle.m[k].dot(triangle.v[k] - triangle.v[(k + 2) % 3]);
    const EdgeSpan s(triangle, k, foot, a2);
    if (!s.inside) continue;
    const EdgeMoments i = CalcEdgeMoments(s);
    const double alpha = bar_W + h * gamma_n - s.p * bar_g.dot(triangle.m[k]);
    const double beta = -bar_g.dot(triangle.e[k]);
    const double phi0 = alpha * i.i0 + beta * i.i1;
    const double phi1 = alpha * i.i1 + beta * i.i2;
    const double t_end = s.t_begin + triangle.length[k];
    bar_v[k] += triangle.m[k] * ((t_end * phi0 - phi1) / triangle.length[k]);
    bar_v[(k + 1) % 3] += triangle.m[k] * ((phi1 - s.t_begin * phi0) / triangle.length[k]);
  }

  // Normal part: ∂φ/∂n = 2h(bar_W + h γn − bar_g·s) − (a² − s²) γn, times λ_k = λ_k(foot) + ∇λ_k·s.
  const Eigen::Matrix3d in_plane = Eigen::Matrix3d::Identity() - n * n.transpose();
  const Eigen::Matrix3d A2 = 0.5 * (in.W * in_plane - in.edge_moment);
  const double k0 = bar_W + h * gamma_n;
  const double constant = 2.0 * h * (k0 * in.A0 - bar_g.dot(in.A1)) - gamma_n * in.W;
  const Eigen::Vector3d linear = 2.0 * h * (k0 * in.A1 - A2 * bar_g) - gamma_n * in.M1;
  for (int k = 0; k < 3; ++k) {
    const int opposite = (k + 1) % 3;  // the edge that vertex k is not on
    const Eigen::Vector3d gradient = -triangle.m[opposite] / height[opposite];
    const double lambda_foot = triangle.m[opposite].dot(triangle.v[opposite] - foot) / height[opposite];
    bar_v[k] += n * (lambda_foot * constant + gradient.dot(linear));
  }
  return bar_v;
}

}  // namespace knap
