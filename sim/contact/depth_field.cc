#include "sim/contact/depth_field.h"

#include <algorithm>
#include <cmath>

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

double CalcDepth(const RoundField& field, const Vector3d& x) {
  const Vector3d d = x - field.center;
  const double along = std::clamp(field.axis.dot(d), -field.half_length, field.half_length);
  return (field.radius * field.radius - (d - along * field.axis).squaredNorm()) / (2.0 * field.radius);
}

double CalcDepth(const CylinderField& field, const Vector3d& x) {
  const Vector3d d = x - field.center;
  const double along = field.axis.dot(d);
  const double across2 = d.squaredNorm() - along * along;
  return std::min((field.radius * field.radius - across2) / (2.0 * field.radius), field.half_length - std::abs(along));
}

}  // namespace knap
