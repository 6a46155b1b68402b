#include "sim/morphology/mean_value_coordinates.h"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

#include "sim/geometry/nearest_point.h"

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
    const Vector3d nearest = CalcNearestToOrigin(r.a, r.b, r.c);
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
