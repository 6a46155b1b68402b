#include "sim/contact/contact_shape.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace knap {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

// The blend of smax that rounds an edge of 90° about as an arc of radius 1 does: it takes as much off the corner.
constexpr double kBlendOfRounding = 1.5;

struct Scalar {
  double value;
  double slope;
  double curvature;
};

Scalar CalcSmoothAbs(double t, double b) {
  if (t >= b) return {t, 1.0, 0.0};
  if (t <= -b) return {-t, -1.0, 0.0};
  const double s = t / b;
  const double s2 = s * s;
  return {b * (3.0 + s2 * (6.0 - s2)) / 8.0, s * (3.0 - s2) / 2.0, 1.5 * (1.0 - s2) / b};
}

double CalcReachOfSmoothMax(double b) { return 3.0 * b / 16.0; }

}  // namespace

ShapeField ShapeField::MakeHalfSpace(double offset) {
  ShapeField field;
  field.radius_ = offset;
  field.reach_.setConstant(std::numeric_limits<double>::infinity());
  return field;
}

ShapeField ShapeField::MakeRoundedCore(const Vector3d& core_half, double radius, const Vector3d& center) {
  ShapeField field;
  field.kind_ = Kind::kRoundedCore;
  field.half_ = core_half;
  field.radius_ = radius;
  field.blend_ = 0.5 * radius;
  for (int i = 0; i < 3; ++i) {
    if (core_half(i) > 0.0) field.blend_ = std::min(field.blend_, core_half(i));
  }
  field.center_ = center;
  field.reach_ = core_half.array() + radius + CalcReachOfSmoothMax(field.blend_);
  return field;
}

ShapeField ShapeField::MakeSolidBox(const Vector3d& half, double rounding, const Vector3d& center) {
  ShapeField field;
  field.kind_ = Kind::kSolidBox;
  field.half_ = half;
  field.blend_ = kBlendOfRounding * rounding;
  field.center_ = center;
  field.reach_ = half;
  return field;
}

bool ShapeField::Evaluate(const Vector3d& point, FieldValue* value) const {
  if (kind_ == Kind::kHalfSpace) {
    if (point.z() >= radius_) return false;
    value->phi = point.z() - radius_;
    value->gradient = Vector3d::UnitZ();
    value->hessian.setZero();
    return true;
  }
  const Vector3d x = point - center_;
  for (int i = 0; i < 3; ++i) {
    if (std::abs(x(i)) >= reach_(i)) return false;
  }
  if (kind_ == Kind::kRoundedCore) {
    double e2 = 0.0;
    Vector3d gradient;
    Vector3d curvature;
    for (int i = 0; i < 3; ++i) {
      if (half_(i) == 0.0) {
        e2 += x(i) * x(i);
        gradient(i) = x(i);
        curvature(i) = 1.0;
        continue;
      }
      const double t = std::abs(x(i)) - half_(i);
      const Scalar a = CalcSmoothAbs(t, blend_);
      const double e = 0.5 * (t + a.value);
      const double slope = 0.5 * (1.0 + a.slope);
      e2 += e * e;
      gradient(i) = std::copysign(e * slope, x(i));
      curvature(i) = slope * slope + e * 0.5 * a.curvature;
    }
    value->phi = (e2 - radius_ * radius_) / (2.0 * radius_);
    if (value->phi >= 0.0) return false;
    value->gradient = gradient / radius_;
    value->hessian = (curvature / radius_).asDiagonal();
    return true;
  }
  const Vector3d q = x.cwiseAbs() - half_;
  const Scalar xy = CalcSmoothAbs(q.x() - q.y(), blend_);
  const double m = 0.5 * (q.x() + q.y() + xy.value);
  if (m >= 0.0) return false;
  const Scalar mz = CalcSmoothAbs(m - q.z(), blend_);
  value->phi = 0.5 * (m + q.z() + mz.value);
  if (value->phi >= 0.0) return false;
  const Vector3d sign(std::copysign(1.0, x.x()), std::copysign(1.0, x.y()), std::copysign(1.0, x.z()));
  const double by_m = 0.5 * (1.0 + mz.slope);
  // Gradients of m and of m − q_z in q.
  const Vector3d dm(0.5 * (1.0 + xy.slope), 0.5 * (1.0 - xy.slope), 0.0);
  const Vector3d difference = dm - Vector3d::UnitZ();
  value->gradient = (by_m * dm + 0.5 * (1.0 - mz.slope) * Vector3d::UnitZ()).cwiseProduct(sign);
  const Vector3d across(1.0, -1.0, 0.0);
  value->hessian = 0.5 * by_m * xy.curvature * across * across.transpose() +
                   0.5 * mz.curvature * difference * difference.transpose();
  value->hessian = sign.asDiagonal() * value->hessian * sign.asDiagonal();
  return true;
}

FeaturePoints MakeBoxFeatures(const BoxGeometry& box, double ball, double spacing) {
  FeaturePoints out;
  out.radius = ball;
  Eigen::Vector3i n;
  for (int i = 0; i < 3; ++i) {
    n(i) = std::max(1, static_cast<int>(std::ceil(2.0 * box.half(i) / spacing * (1.0 - 1e-9))));
  }
  const Vector3d inner = box.half.array() - ball;
  for (int i = 0; i <= n.x(); ++i) {
    for (int j = 0; j <= n.y(); ++j) {
      for (int k = 0; k <= n.z(); ++k) {
        const Eigen::Vector3i at(i, j, k);
        double area = 0.0;
        int faces = 0;
        for (int axis = 0; axis < 3; ++axis) {
          if (at(axis) != 0 && at(axis) != n(axis)) continue;
          ++faces;
          double share = 1.0;
          for (const int other : {(axis + 1) % 3, (axis + 2) % 3}) {
            const bool at_end = at(other) == 0 || at(other) == n(other);
            share *= 2.0 * box.half(other) / n(other) * (at_end ? 0.5 : 1.0);
          }
          area += share;
        }
        if (faces == 0) continue;
        const Vector3d unit = 2.0 * at.cast<double>().cwiseQuotient(n.cast<double>()) - Vector3d::Ones();
        out.p_B.push_back(box.center + unit.cwiseProduct(inner));
        out.area.push_back(area / faces);
      }
    }
  }
  return out;
}

FeaturePoints MakeCapsuleFeatures(const CapsuleGeometry& capsule, double spacing) {
  FeaturePoints out;
  out.radius = capsule.radius;
  const int n = std::max(1, static_cast<int>(std::ceil(2.0 * capsule.half_length / spacing * (1.0 - 1e-9))));
  const double strip = 4.0 * capsule.radius * capsule.half_length / n;
  for (int k = 0; k <= n; ++k) {
    const bool at_end = k == 0 || k == n;
    out.p_B.push_back(capsule.center + Vector3d(0.0, 0.0, capsule.half_length * (2.0 * k / n - 1.0)));
    out.area.push_back(at_end ? 0.5 * (strip + std::numbers::pi * capsule.radius * capsule.radius) : strip);
  }
  return out;
}

}  // namespace knap
