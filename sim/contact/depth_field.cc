#include "sim/contact/depth_field.h"

namespace knap {

using Eigen::Vector3d;

PolyhedralField PolyhedralField::MakeHalfSpace() {
  PolyhedralField field;
  field.planes.push_back({Vector3d::UnitZ(), 0.0});
  return field;
}

PolyhedralField PolyhedralField::MakeBox(const Vector3d& half, const Vector3d& center) {
  PolyhedralField field{{}, Eigen::AlignedBox3d(center - half, center + half), half.minCoeff()};
  for (int i = 0; i < 3; ++i) {
    field.planes.push_back({Vector3d::Unit(i), half(i) + center(i)});
    field.planes.push_back({-Vector3d::Unit(i), half(i) - center(i)});
  }
  return field;
}

}  // namespace knap
