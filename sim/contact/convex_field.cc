#include "sim/contact/convex_field.h"

#include <Eigen/Geometry>
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

using Eigen::Vector3d;
using Eigen::Vector3i;
using Eigen::Vector4d;

namespace {

constexpr double kTolerance = 1e-6;  // of the size

// One plane of a linear program: row·y ≤ d.
template <int N>
struct Halving {
  Eigen::Matrix<double, N, 1> row;
  double d = 0.0;
};
Halving<3> MakeHalving(const FieldPlane& plane, const Halving<3>&) { return {plane.n, plane.d}; }
Halving<4> MakeHalving(const FieldPlane& plane, const Halving<4>&) {
  return {(Vector4d() << plane.n, 1.0).finished(), plane.d};
}

// The y with the most c·y under all planes, by the dual simplex method: N of them hold it, `held` at first, c a sum of
// their rows with shares ≥ 0; the one that y is farthest through replaces one of them until none is left. c·y falls
// from step to step and is never less than the answer, also where the steps run out.
template <int N>
Eigen::Matrix<double, N, 1> Maximize(const Eigen::Matrix<double, N, 1>& c, const std::vector<FieldPlane>& planes,
                                     double slack_allowed, std::array<Halving<N>, N> held) {
  Eigen::Matrix<double, N, 1> y;
  const int most_steps = 100 + 10 * static_cast<int>(planes.size());
  for (int step = 0; step < most_steps; ++step) {
    Eigen::Matrix<double, N, N> A;
    Eigen::Matrix<double, N, 1> d;
    for (int k = 0; k < N; ++k) {
      A.row(k) = held[static_cast<std::size_t>(k)].row.transpose();
      d(k) = held[static_cast<std::size_t>(k)].d;
    }
    const Eigen::Matrix<double, N, N> inverse = A.inverse();
    y = inverse * d;
    std::optional<Halving<N>> worst;
    double least = -slack_allowed;
    for (const FieldPlane& plane : planes) {
      const Halving<N> halving = MakeHalving(plane, Halving<N>{});
      const double slack = halving.d - halving.row.dot(y);
      if (slack < least) {
        least = slack;
        worst = halving;
      }
    }
    if (!worst) return y;
    const Eigen::Matrix<double, N, 1> entering = inverse.transpose() * worst->row;
    const Eigen::Matrix<double, N, 1> shares = inverse.transpose() * c;
    int leaving = -1;
    for (int k = 0; k < N; ++k) {
      if (!(entering(k) > 1e-12)) continue;
      if (leaving < 0 || shares(k) * entering(leaving) < shares(leaving) * entering(k)) leaving = k;
    }
    if (leaving < 0) return y;
    held[static_cast<std::size_t>(leaving)] = *worst;
  }
  return y;
}

constexpr double kSlack = 1e-12;  // of the size
constexpr double kFar = 10.0;     // sizes: far enough to have no part in an answer

// The largest e: the radius r of the largest ball inside, that is, the most r with n_i·x + r ≤ d_i for all planes.
double CalcDeepest(const PolyhedralField& field) {
  const double size = field.bounds.diagonal().norm();
  const Vector3d middle = field.bounds.center();
  // At first a tetrahedron around it all.
  std::array<Halving<4>, 4> held;
  const std::array<Vector3d, 4> corners = {Vector3d(1, 1, 1), Vector3d(1, -1, -1), Vector3d(-1, 1, -1),
                                           Vector3d(-1, -1, 1)};
  for (std::size_t k = 0; k < 4; ++k) {
    const Vector3d n = corners[k].normalized();
    held[k] = {(Vector4d() << n, 1.0).finished(), n.dot(middle) + kFar * size};
  }
  return Maximize<4>(Vector4d::Unit(3), field.planes, kSlack * size, held)(3);
}

// The most of u·x inside of the planes; that of a far corner where nothing bounds it.
double CalcExtent(const Vector3d& u, const PolyhedralField& field) {
  const double size = field.bounds.diagonal().norm();
  const Vector3d v = u.unitOrthogonal();
  const Vector3d w = u.cross(v);
  std::array<Halving<3>, 3> held;
  const std::array<Vector3d, 3> sides = {Vector3d(u + v), Vector3d(u - 0.5 * v + w), Vector3d(u - 0.5 * v - w)};
  for (std::size_t k = 0; k < 3; ++k) {
    const Vector3d n = sides[k].normalized();
    held[k] = {n, n.dot(field.bounds.center()) + kFar * size};
  }
  return u.dot(Maximize<3>(u, field.planes, kSlack * size, held));
}

}  // namespace

std::optional<std::vector<ConvexFace>> FindConvexFaces(const TriangleMesh& mesh) {
  std::vector<ConvexFace> faces;
  const double tolerance = kTolerance * CalcBoundingBox(mesh).diagonal().norm();
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
    const auto taken = std::find_if(faces.begin(), faces.end(), [&](const ConvexFace& face) {
      if (!(face.plane.n.dot(areas[i]) > 0.0)) return false;
      for (int k = 0; k < 3; ++k) {
        if (std::abs(face.plane.CalcHeight(mesh.vertices[t[k]])) > tolerance) return false;
      }
      return true;
    });
    if (taken != faces.end()) {
      taken->triangles.push_back(static_cast<int>(i));
      continue;
    }
    if (faces.size() == kMostFaces) return std::nullopt;
    const Vector3d n = areas[i].normalized();
    const FieldPlane plane{n, n.dot(mesh.vertices[t[0]])};
    for (const Vector3d& x : mesh.vertices) {
      if (plane.CalcHeight(x) > tolerance) return std::nullopt;
    }
    faces.push_back({plane, {static_cast<int>(i)}});
  }
  return faces;
}

std::optional<PolyhedralField> MakeConvexField(const TriangleMesh& mesh) {
  const std::optional<std::vector<ConvexFace>> faces = FindConvexFaces(mesh);
  if (!faces) return std::nullopt;
  PolyhedralField field;
  field.bounds = CalcBoundingBox(mesh);
  for (const ConvexFace& face : *faces) field.planes.push_back(face.plane);
  field.deepest = CalcDeepest(field);
  return field;
}

bool FitBounds(PolyhedralField* field) {
  const double size = field->bounds.diagonal().norm();
  Eigen::AlignedBox3d bounds;
  for (int k = 0; k < 3; ++k) {
    bounds.max()(k) = CalcExtent(Vector3d::Unit(k), *field);
    bounds.min()(k) = -CalcExtent(-Vector3d::Unit(k), *field);
  }
  if (!(bounds.diagonal().norm() < kFar * size)) return false;
  field->bounds = bounds;
  field->deepest = CalcDeepest(*field);
  return field->deepest > 0.0;
}

std::optional<MeshGeometry> MakeConvexMesh(const TriangleMesh& mesh) {
  std::optional<PolyhedralField> field = MakeConvexField(mesh);
  if (!field) return std::nullopt;
  return MeshGeometry{std::make_shared<ContactMesh>(mesh), std::make_shared<PolyhedralField>(*std::move(field))};
}

}  // namespace knap
