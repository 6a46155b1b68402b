#include "sim/geometry/winding_number.h"

#include <cmath>
#include <numbers>

namespace knap {

using Eigen::Vector3d;
using Eigen::Vector3i;

double CalcWindingNumber(const TriangleMesh& mesh, const std::vector<int>& triangles, const Vector3d& p) {
  double half_angles = 0.0;
  for (const int i : triangles) {
    const Vector3i& t = mesh.triangles[static_cast<std::size_t>(i)];
    const Vector3d a = mesh.vertices[t[0]] - p;
    const Vector3d b = mesh.vertices[t[1]] - p;
    const Vector3d c = mesh.vertices[t[2]] - p;
    const double la = a.norm(), lb = b.norm(), lc = c.norm();
    half_angles += std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
  }
  return half_angles / (2.0 * std::numbers::pi);
}

}  // namespace knap
