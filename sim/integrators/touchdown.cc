#include "sim/integrators/touchdown.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <variant>

#include "sim/contact/contact_mesh.h"
#include "sim/math/overloaded.h"

namespace knap {

using Eigen::Vector3d;

namespace {

// The point of a shape's core nearest to c, in the shape's body, and by how much the core is inflated.
struct NearestPoint {
  Vector3d p = Vector3d::Zero();
  double inflation = 0.0;
  int triangle = -1;
  Vector3d barycentric = Vector3d::Zero();
};

// Two points of two bodies along a normal.
struct Gap {
  Vector3d arm_B, arm_S, w_B, w_S;  // in W
  double gap = 0.0, rate = 0.0;
};

Gap CalcGap(const Approach& at, const ContactPair& contact, const std::vector<BodyKinematics>& kinematics) {
  const auto& sphere = std::get<SphereGeometry>(contact.shapes[at.ball]);
  const BodyKinematics& B = kinematics[contact.bodies[at.ball]];
  const BodyKinematics& S = kinematics[contact.bodies[1 - at.ball]];
  Vector3d p_S = at.p_S;
  if (at.triangle >= 0) {
    const Facet& facet = std::get<MeshGeometry>(contact.shapes[1 - at.ball]).mesh->facets()[at.triangle];
    p_S = at.barycentric(0) * facet.Place(0) + at.barycentric(1) * facet.Place(1) + at.barycentric(2) * facet.Place(2);
  }
  const Vector3d c_W = B.X_WB * sphere.center;
  const Vector3d p_W = S.X_WB * p_S;
  Gap out{c_W - B.X_WB.p, p_W - S.X_WB.p, B.X_WB.R * B.V.head<3>(), S.X_WB.R * S.V.head<3>()};
  out.gap = at.n_W.dot(c_W - p_W) - sphere.radius - at.inflation;
  out.rate = at.n_W.dot(B.X_WB.R * B.V.tail<3>() + out.w_B.cross(out.arm_B) - S.X_WB.R * S.V.tail<3>() -
                        out.w_S.cross(out.arm_S));
  return out;
}

// [Ericson 2005, §5.1.5]
Vector3d FindOnTriangle(const std::array<Vector3d, 3>& v, const Vector3d& c) {
  const Vector3d ab = v[1] - v[0];
  const Vector3d ac = v[2] - v[0];
  const Vector3d ap = c - v[0];
  const double d1 = ab.dot(ap);
  const double d2 = ac.dot(ap);
  if (d1 <= 0.0 && d2 <= 0.0) return Vector3d(1.0, 0.0, 0.0);
  const Vector3d bp = c - v[1];
  const double d3 = ab.dot(bp);
  const double d4 = ac.dot(bp);
  if (d3 >= 0.0 && d4 <= d3) return Vector3d(0.0, 1.0, 0.0);
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) {
    const double s = d1 / (d1 - d3);
    return Vector3d(1.0 - s, s, 0.0);
  }
  const Vector3d cp = c - v[2];
  const double d5 = ab.dot(cp);
  const double d6 = ac.dot(cp);
  if (d6 >= 0.0 && d5 <= d6) return Vector3d(0.0, 0.0, 1.0);
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) {
    const double s = d2 / (d2 - d6);
    return Vector3d(1.0 - s, 0.0, s);
  }
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0) {
    const double s = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return Vector3d(0.0, 1.0 - s, s);
  }
  const double sum = va + vb + vc;
  return Vector3d(va / sum, vb / sum, vc / sum);
}

NearestPoint FindNearest(const ContactGeometry& shape, const Vector3d& c) {
  return std::visit(
      Overloaded{[&](const HalfSpaceGeometry& s) { return NearestPoint{c - s.plane.CalcHeight(c) * s.plane.n}; },
                 [](const SphereGeometry& s) {
                   return NearestPoint{s.center, s.radius};
                 },
                 [&](const CapsuleGeometry& s) {
                   const double along = std::clamp(s.axis.dot(c - s.center), -s.half_length, s.half_length);
                   return NearestPoint{s.center + along * s.axis, s.radius};
                 },
                 [&](const CylinderGeometry& s) {
                   const Vector3d d = c - s.center;
                   const double along = s.axis.dot(d);
                   Vector3d across = d - along * s.axis;
                   if (across.norm() > s.radius) across *= s.radius / across.norm();
                   return NearestPoint{s.center + across + std::clamp(along, -s.half_length, s.half_length) * s.axis};
                 },
                 [&](const BoxGeometry& s) {
                   const Vector3d d = s.R.transpose() * (c - s.center);
                   return NearestPoint{s.center + s.R * d.cwiseMax(-s.half).cwiseMin(s.half)};
                 },
                 [&](const MeshGeometry& s) {
                   NearestPoint nearest;
                   double least = std::numeric_limits<double>::infinity();
                   const std::vector<Facet>& facets = s.mesh->facets();
                   for (int t = 0; t < static_cast<int>(facets.size()); ++t) {
                     const Facet& facet = facets[t];
                     const std::array<Vector3d, 3> v{facet.Place(0), facet.Place(1), facet.Place(2)};
                     const Vector3d b = FindOnTriangle(v, c);
                     const Vector3d p = b(0) * v[0] + b(1) * v[1] + b(2) * v[2];
                     const double distance = (c - p).squaredNorm();
                     if (distance >= least) continue;
                     least = distance;
                     nearest = {p, 0.0, t, b};
                   }
                   return nearest;
                 }},
      shape);
}

// Of a point of a body that lies `arm` from its origin: cotangents of n·(its place) and n·(its velocity).
StateCotangent MakeCotangent(int body, const Vector3d& arm, const Vector3d& w, const Vector3d& n, double by_gap,
                             double by_rate) {
  StateCotangent at;
  at.body = body;
  at.p_W = by_gap * n;
  at.v_W = by_rate * n;
  at.r_W = arm.cross(by_gap * n + by_rate * n.cross(w));
  at.w_W = arm.cross(by_rate * n);
  return at;
}

}  // namespace

std::optional<Touchdown> FindTouchdown(const ContactPair& contact, const std::vector<BodyKinematics>& kinematics) {
  int ball = 0;
  if (!std::holds_alternative<SphereGeometry>(contact.shapes[0])) ball = 1;
  const auto* sphere = std::get_if<SphereGeometry>(&contact.shapes[ball]);
  if (sphere == nullptr) return std::nullopt;
  const ContactGeometry& surface = contact.shapes[1 - ball];
  const BodyKinematics& S = kinematics[contact.bodies[1 - ball]];
  const Vector3d c_W = kinematics[contact.bodies[ball]].X_WB * sphere->center;
  const NearestPoint nearest = FindNearest(surface, S.X_WB.ApplyInverse(c_W));
  const Vector3d from_p = c_W - S.X_WB * nearest.p;
  const double distance = from_p.norm();
  if (distance == 0.0) return std::nullopt;
  Touchdown out;
  out.approach = {ball, from_p / distance, nearest.p, nearest.triangle, nearest.barycentric, nearest.inflation};
  const Gap at = CalcGap(out.approach, contact, kinematics);
  if (!(at.gap >= 0.0 && at.rate < -kLeastApproach)) return std::nullopt;
  const Vector3d& n = out.approach.n_W;
  const double by_gap = -1.0 / at.rate;
  const double by_rate = at.gap / (at.rate * at.rate);
  out.in = -at.gap / at.rate;
  out.bodies[0] = MakeCotangent(contact.bodies[ball], at.arm_B, at.w_B, n, by_gap, by_rate);
  out.bodies[1] = MakeCotangent(contact.bodies[1 - ball], at.arm_S, at.w_S, n, -by_gap, -by_rate);
  const auto* mesh = std::get_if<MeshGeometry>(&surface);
  if (mesh != nullptr && mesh->IsDesigned()) {
    const Vector3d bar_p = S.X_WB.R.transpose() * (-by_gap * n - by_rate * n.cross(at.w_S));
    const Eigen::Vector3i corners = mesh->mesh->triangles()[nearest.triangle];
    for (int i = 0; i < 3; ++i) out.vertices.emplace_back(corners(i), nearest.barycentric(i) * bar_p);
  }
  return out;
}

std::optional<double> CalcTouchdownIn(const Approach& approach, const ContactPair& contact,
                                      const std::vector<BodyKinematics>& kinematics) {
  const Gap at = CalcGap(approach, contact, kinematics);
  if (!(at.rate < 0.0)) return std::nullopt;
  return -at.gap / at.rate;
}

}  // namespace knap
