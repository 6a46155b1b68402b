#include "sim/contact/convex_field.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numeric>
#include <utility>
#include <vector>

#include "sim/contact/contact_mesh.h"

namespace knap {

using Eigen::Matrix4d;
using Eigen::Vector3d;
using Eigen::Vector3i;
using Eigen::Vector4d;

namespace {

constexpr double kTolerance = 1e-6;  // of the size

// The largest e: the radius r of the largest ball inside, that is, the most r with n_i·x + r ≤ d_i for all planes. By
// the dual simplex method: four planes hold the ball, the one that it is farthest through replaces one of them until
// none is left. r falls from step to step and is never less than the answer, also where the steps run out.
double CalcDeepest(const PolyhedralField& field) {
  const double size = field.bounds.diagonal().norm();
  const Vector3d middle = field.bounds.center();
  // At first a tetrahedron around it all, far enough to have no part in the answer.
  std::array<FieldPlane, 4> held;
  const std::array<Vector3d, 4> corners = {Vector3d(1, 1, 1), Vector3d(1, -1, -1), Vector3d(-1, 1, -1),
                                           Vector3d(-1, -1, 1)};
  for (std::size_t k = 0; k < 4; ++k) {
    held[k].n = corners[k].normalized();
    held[k].d = held[k].n.dot(middle) + 10.0 * size;
  }
  const int most_steps = 100 + 10 * static_cast<int>(field.planes.size());
  double r = size;
  for (int step = 0; step < most_steps; ++step) {
    Matrix4d A;
    Vector4d d;
    for (int k = 0; k < 4; ++k) {
      A.row(k) << held[k].n.transpose(), 1.0;
      d(k) = held[k].d;
    }
    const Matrix4d inverse = A.inverse();
    const Vector4d ball = inverse * d;
    r = ball(3);
    const FieldPlane* worst = nullptr;
    double least = -1e-12 * size;
    for (const FieldPlane& plane : field.planes) {
      const double slack = plane.d - plane.n.dot(ball.head<3>()) - r;
      if (slack < least) {
        least = slack;
        worst = &plane;
      }
    }
    if (worst == nullptr) return r;
    const Vector4d entering = inverse.transpose() * (Vector4d() << worst->n, 1.0).finished();
    const Vector4d shares = inverse.row(3).transpose();
    int leaving = -1;
    for (int k = 0; k < 4; ++k) {
      if (!(entering(k) > 1e-12)) continue;
      if (leaving < 0 || shares(k) * entering(leaving) < shares(leaving) * entering(k)) leaving = k;
    }
    if (leaving < 0) return r;
    held[static_cast<std::size_t>(leaving)] = *worst;
  }
  return r;
}

}  // namespace

std::optional<PolyhedralField> MakeConvexField(const TriangleMesh& mesh) {
  PolyhedralField field;
  field.bounds = CalcBoundingBox(mesh);
  const double tolerance = kTolerance * field.bounds.diagonal().norm();
  // Twice the areas; the largest first, whose normals are the most exact.
  std::vector<Vector3d> areas;
  for (const Vector3i& t : mesh.triangles) {
    const Vector3d& a = mesh.vertices[t[0]];
    areas.push_back((mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a));
  }
  std::vector<std::size_t> order(areas.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t i, std::size_t j) { return areas[i].squaredNorm() > areas[j].squaredNorm(); });
  for (const std::size_t i : order) {
    const Vector3i& t = mesh.triangles[i];
    const bool is_taken = std::any_of(field.planes.begin(), field.planes.end(), [&](const FieldPlane& plane) {
      if (!(plane.n.dot(areas[i]) > 0.0)) return false;
      for (int k = 0; k < 3; ++k) {
        if (std::abs(plane.n.dot(mesh.vertices[t[k]]) - plane.d) > tolerance) return false;
      }
      return true;
    });
    if (is_taken) continue;
    if (field.planes.size() == kMostFaces) return std::nullopt;
    const Vector3d n = areas[i].normalized();
    const FieldPlane plane{n, n.dot(mesh.vertices[t[0]])};
    for (const Vector3d& x : mesh.vertices) {
      if (n.dot(x) - plane.d > tolerance) return std::nullopt;
    }
    field.planes.push_back(plane);
  }
  field.deepest = CalcDeepest(field);
  return field;
}

std::optional<MeshGeometry> MakeConvexMesh(const TriangleMesh& mesh) {
  std::optional<PolyhedralField> field = MakeConvexField(mesh);
  if (!field) return std::nullopt;
  return MeshGeometry{std::make_shared<ContactMesh>(mesh), std::make_shared<PolyhedralField>(*std::move(field))};
}

}  // namespace knap
