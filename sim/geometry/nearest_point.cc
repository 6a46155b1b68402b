#include "sim/geometry/nearest_point.h"

#include <Eigen/Geometry>

namespace knap {

using Eigen::Vector3d;

Vector3d CalcNearestToOrigin(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const Vector3d ab = b - a;
  const Vector3d ac = c - a;
  const double d1 = -ab.dot(a), d2 = -ac.dot(a);
  if (d1 <= 0 && d2 <= 0) return Vector3d::UnitX();
  const double d3 = -ab.dot(b), d4 = -ac.dot(b);
  if (d3 >= 0 && d4 <= d3) return Vector3d::UnitY();
  const double d5 = -ab.dot(c), d6 = -ac.dot(c);
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

}  // namespace knap
