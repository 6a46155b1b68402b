#include "sim/contact/contact_mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace knap {

using Eigen::Vector3d;
using Eigen::Vector3i;

ContactMesh::ContactMesh(const TriangleMesh& mesh)
    : triangles_(mesh.triangles),
      vertex_count_(static_cast<int>(mesh.vertices.size())),
      bounds_(CalcBoundingBox(mesh)),
      bvh_(std::make_unique<TriangleBvh>(mesh)) {
  facets_.reserve(mesh.triangles.size());
  balls_.reserve(mesh.triangles.size());
  for (const Vector3i& t : mesh.triangles) {
    AddFacet(std::array{mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]});
  }
}

ContactMesh ContactMesh::MakeBox(const BoxGeometry& box) {
  ContactMesh out;
  const Vector3d reach = box.R.cwiseAbs() * box.half;
  out.bounds_ = Eigen::AlignedBox3d(box.center - reach, box.center + reach);
  for (int i = 0; i < 3; ++i) {
    for (const double side : {1.0, -1.0}) {
      const Vector3d n = side * box.half(i) * box.R.col(i);
      const Vector3d a = box.half((i + 1) % 3) * box.R.col((i + 1) % 3);
      const Vector3d b = side * box.half((i + 2) % 3) * box.R.col((i + 2) % 3);
      const Vector3d middle = box.center + n;
      out.AddFacet(std::array<Vector3d, 4>{middle - a - b, middle + a - b, middle + a + b, middle - a + b});
    }
  }
  return out;
}

ContactMesh ContactMesh::MakeCylinder(const CylinderGeometry& cylinder) {
  constexpr double kAngle = 2.0 * std::numbers::pi / kCylinderSides;
  // The area of the polygon is n/2 ρ² sin(2π/n).
  const double rho = cylinder.radius * std::sqrt(kAngle / std::sin(kAngle));
  const Vector3d x = cylinder.axis.unitOrthogonal();
  const Vector3d y = cylinder.axis.cross(x);
  TriangleMesh prism;
  for (const double end : {-1.0, 1.0}) {
    const Vector3d middle = cylinder.center + end * cylinder.half_length * cylinder.axis;
    for (int k = 0; k < kCylinderSides; ++k) {
      prism.vertices.push_back(middle + rho * (std::cos(k * kAngle) * x + std::sin(k * kAngle) * y));
    }
  }
  const int low = 2 * kCylinderSides;
  for (const double end : {-1.0, 1.0}) {
    prism.vertices.push_back(cylinder.center + end * cylinder.half_length * cylinder.axis);
  }
  for (int k = 0; k < kCylinderSides; ++k) {
    const int next = (k + 1) % kCylinderSides;
    const int up = kCylinderSides + k, next_up = kCylinderSides + next;
    prism.triangles.emplace_back(low, next, k);
    prism.triangles.emplace_back(k, next, next_up);
    prism.triangles.emplace_back(k, next_up, up);
    prism.triangles.emplace_back(low + 1, up, next_up);
  }
  return ContactMesh(prism);
}

void ContactMesh::AddFacet(std::span<const Vector3d> corners) {
  Eigen::AlignedBox3d box;
  for (const Vector3d& x : corners) box.extend(x);
  Ball ball{box.center(), 0.0};
  for (const Vector3d& x : corners) ball.radius = std::max(ball.radius, (x - ball.center).norm());
  ball.radius *= 1.0 + 1e-9;
  facets_.push_back(Facet::Make(corners));
  balls_.push_back(ball);
}

void ContactMesh::FindFacets(const Eigen::AlignedBox3d& box, std::vector<int>* facets) const {
  if (bvh_ != nullptr) return bvh_->FindTriangles(box, facets);
  facets->clear();
  for (int i = 0; i < static_cast<int>(facets_.size()); ++i) facets->push_back(i);
}

}  // namespace knap
