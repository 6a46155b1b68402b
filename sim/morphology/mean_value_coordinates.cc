#include "sim/morphology/mean_value_coordinates.h"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

namespace knap {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

// Of the cage's diagonal: nearer than this a point counts as on the surface.
constexpr double kOnSurface = 1e-12;

// Height over a triangle's plane, of the distance from the triangle: below this it is seen edge-on. Its true
// weight then is of this order, and computing it would lose as much to rounding.
constexpr double kEdgeOn = 1e-8;

// A triangle relative to the point: corners r_i = c_i - x.
struct Corners {
  Vector3d a, b, c;
};

// Barycentric coordinates of the point of the triangle nearest to the origin, by the Voronoi region it lies
// in: a corner, an edge or the inside [Ericson, Real-Time Collision Detection, 5.1.5].
Vector3d CalcNearestPoint(const Corners& r) {
  const Vector3d ab = r.b - r.a;
  const Vector3d ac = r.c - r.a;
  const double d1 = -ab.dot(r.a), d2 = -ac.dot(r.a);
  if (d1 <= 0 && d2 <= 0) return Vector3d::UnitX();
  const double d3 = -ab.dot(r.b), d4 = -ac.dot(r.b);
  if (d3 >= 0 && d4 <= d3) return Vector3d::UnitY();
  const double d5 = -ab.dot(r.c), d6 = -ac.dot(r.c);
  if (d6 >= 0 && d5 <= d6) return Vector3d::UnitZ();

  const double area_c = d1 * d4 - d3 * d2;
  if (area_c <= 0 && d1 >= 0 && d3 <= 0) {
    const double s = d1 / (d1 - d3);
    return {1 - s, s, 0};
  }
  const double area_b = d5 * d2 - d1 * d6;
  if (area_b <= 0 && d2 >= 0 && d6 <= 0) {
    const double s = d2 / (d2 - d6);
    return {1 - s, 0, s};
  }
  const double area_a = d3 * d6 - d5 * d4;
  if (area_a <= 0 && d4 >= d3 && d5 >= d6) {
    const double s = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return {0, 1 - s, s};
  }
  return Vector3d(area_a, area_b, area_c) / (area_a + area_b + area_c);
}

// Half the angle between unit vectors, times the unit normal of their plane.
Vector3d CalcEdgeTerm(const Vector3d& u, const Vector3d& v) {
  const double half_angle = std::atan2((u - v).norm(), (u + v).norm());
  return half_angle * u.cross(v).normalized();
}

}  // namespace

void CheckCage(const TriangleMesh& cage) {
  const MeshDefects defects = FindDefects(cage);
  if (!defects.empty()) {
    throw std::invalid_argument(
        fmt::format("a cage must be closed and face outwards; this one has {}", defects.Describe()));
  }
}

Eigen::VectorXd CalcMeanValueCoordinates(const TriangleMesh& cage, const Vector3d& p) {
  const double on_surface = kOnSurface * CalcBoundingBox(cage).diagonal().norm();
  Eigen::VectorXd weights = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(cage.vertices.size()));
  for (const Vector3i& t : cage.triangles) {
    const Corners r{cage.vertices[t[0]] - p, cage.vertices[t[1]] - p, cage.vertices[t[2]] - p};
    const Vector3d nearest = CalcNearestPoint(r);
    const double distance = (nearest[0] * r.a + nearest[1] * r.b + nearest[2] * r.c).norm();
    if (distance <= on_surface) {
      weights.setZero();
      for (int k = 0; k < 3; ++k) weights[t[k]] = nearest[k];
      return weights;
    }
    const Vector3d normal = (r.b - r.a).cross(r.c - r.a).normalized();
    if (std::abs(normal.dot(r.a)) <= kEdgeOn * distance) continue;

    const Vector3d d(r.a.norm(), r.b.norm(), r.c.norm());
    const Vector3d ua = r.a / d[0], ub = r.b / d[1], uc = r.c / d[2];
    const Vector3d mean = CalcEdgeTerm(ub, uc) + CalcEdgeTerm(uc, ua) + CalcEdgeTerm(ua, ub);
    // With edge normals of any length, here the cross products, every denominator n_i . u_i is the one
    // determinant. It is taken once, so that its rounding cannot tilt the three weights against each other.
    const double determinant = ua.dot(ub.cross(uc));
    weights[t[0]] += ub.cross(uc).dot(mean) / (d[0] * determinant);
    weights[t[1]] += uc.cross(ua).dot(mean) / (d[1] * determinant);
    weights[t[2]] += ua.cross(ub).dot(mean) / (d[2] * determinant);
  }
  return weights / weights.sum();
}

Eigen::MatrixXd CalcMeanValueWeights(const TriangleMesh& cage, const TriangleMesh& mesh) {
  CheckCage(cage);
  Eigen::MatrixXd weights(mesh.vertices.size(), cage.vertices.size());
  for (size_t i = 0; i < mesh.vertices.size(); ++i) {
    weights.row(static_cast<Eigen::Index>(i)) = CalcMeanValueCoordinates(cage, mesh.vertices[i]).transpose();
  }
  return weights;
}

}  // namespace knap
