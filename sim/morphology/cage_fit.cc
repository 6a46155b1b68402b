#include "sim/morphology/cage_fit.h"

#include <fmt/format.h>

#include <numeric>
#include <vector>

#include "sim/geometry/nearest_point.h"
#include "sim/geometry/winding_number.h"

namespace knap {
namespace {

using Eigen::Vector3d;

constexpr double kOnCage = 1e-9;  // of the cage's diagonal

bool IsOnSurface(const TriangleMesh& cage, const Vector3d& p, double tolerance) {
  for (const Eigen::Vector3i& t : cage.triangles) {
    const Vector3d a = cage.vertices[t[0]] - p;
    const Vector3d b = cage.vertices[t[1]] - p;
    const Vector3d c = cage.vertices[t[2]] - p;
    const Vector3d nearest = CalcNearestToOrigin(a, b, c);
    if ((nearest[0] * a + nearest[1] * b + nearest[2] * c).norm() <= tolerance) return true;
  }
  return false;
}

std::string FormatPoint(const Vector3d& p) {
  return fmt::format("({:.6g}, {:.6g}, {:.6g})", 1000.0 * p.x(), 1000.0 * p.y(), 1000.0 * p.z());
}

std::string FormatSize(const Eigen::AlignedBox3d& box) {
  const Vector3d size = 1000.0 * box.sizes();
  return fmt::format("{:.6g} x {:.6g} x {:.6g} mm, from {} to {}", size.x(), size.y(), size.z(), FormatPoint(box.min()),
                     FormatPoint(box.max()));
}

}  // namespace

std::string DescribeMisfit(const TriangleMesh& mesh, const TriangleMesh& cage) {
  const Eigen::AlignedBox3d box = CalcBoundingBox(cage);
  const double tolerance = kOnCage * box.diagonal().norm();
  std::vector<int> all(cage.triangles.size());
  std::iota(all.begin(), all.end(), 0);
  int outside = 0;
  Vector3d example = Vector3d::Zero();
  for (const Vector3d& p : mesh.vertices) {
    // On the surface the winding number is anything from 0 to 1.
    if (box.contains(p) && CalcWindingNumber(cage, all, p) > 0.5) continue;
    if (IsOnSurface(cage, p, tolerance)) continue;
    if (outside++ == 0) example = p;
  }
  if (outside == 0) return {};
  return fmt::format(
      "the mesh lies outside its cage: {} of its {} vertices, {} mm for one; the mesh is {}, the cage {}; are both in "
      "the "
      "same unit?",
      outside, mesh.vertices.size(), FormatPoint(example), FormatSize(CalcBoundingBox(mesh)), FormatSize(box));
}

}  // namespace knap
