#include "sim/contact/depth_field.h"

namespace knap {

using Eigen::Vector3d;

PolyhedralField PolyhedralField::MakeHalfSpace(const FieldPlane& plane) {
  PolyhedralField field;
  field.planes.push_back(plane);
  return field;
}

PolyhedralField PolyhedralField::MakeBox(const Vector3d& half, const Vector3d& center, const Eigen::Matrix3d& R) {
  const Vector3d reach = R.cwiseAbs() * half;
  PolyhedralField field{{}, Eigen::AlignedBox3d(center - reach, center + reach), half.minCoeff()};
  for (int i = 0; i < 3; ++i) {
    const Vector3d n = R.col(i);
    field.planes.push_back({n, half(i) + n.dot(center)});
    field.planes.push_back({-n, half(i) - n.dot(center)});
  }
  return field;
}

}  // namespace knap
