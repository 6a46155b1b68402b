#include "sim/contact/cylinder_integrals.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "sim/contact/facet_integrals.h"
#include "sim/contact/planar_moments.h"

namespace knap {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

// Gauss-Legendre on [−1, 1] with two points.
constexpr double kLineAt = 0.5773502691896258;
constexpr double kLongestPiece = 0.25 * std::numbers::pi;  // over which eight points leave 1e-12 [rad]

class CylinderSum {
 public:
  CylinderSum(const SolidCylinder& cylinder, const FieldPlane& ground, PatchIntegrals* patch, PatchJacobian* jacobian)
      : cylinder_(cylinder), ground_(ground), patch_(patch), jacobian_(jacobian) {}

  void Run() {
    for (const double end : {1.0, -1.0}) AddEnd(end);
    AddSide();
    if (jacobian_ != nullptr) FinishJacobian(*patch_, jacobian_);
  }

 private:
  void AddEnd(double end) {
    const double r = cylinder_.radius;
    FacetRegion region;
    PlaneFrame& f = region.frame;
    f.o = cylinder_.center + end * cylinder_.half_length * cylinder_.direction;
    f.n = end * cylinder_.direction;
    // w runs level, and u up or down: the water line is straight across u.
    const Vector3d level = ground_.n.cross(f.n);
    f.m = level.norm() > 1e-12 ? Vector3d(level.normalized()) : f.n.unitOrthogonal();
    f.t = f.m.cross(f.n);
    const double height = ground_.CalcHeight(f.o);
    const double slope = ground_.n.dot(f.t);  // e = −(height + slope u)
    double low = -r;
    double high = r;
    if (std::abs(slope) * r <= std::abs(height)) {
      if (height > 0.0) return;
    } else if (slope > 0.0) {
      high = -height / slope;
    } else {
      low = -height / slope;
    }
    const std::array<Eigen::Vector2d, 4> polygon = {Eigen::Vector2d(low, -r), Eigen::Vector2d(high, -r),
                                                    Eigen::Vector2d(high, r), Eigen::Vector2d(low, r)};
    region.moments = CalcConicMoments(polygon, Conic::Around(r * r, 1.0, 0.0));
    if (!(region.moments.area() > 0.0)) return;
    // m is level up to rounding, or e is all but even.
    region.field.e << -height, -slope, -ground_.n.dot(f.m), 0.0, 0.0, 0.0;
    region.field.gradient << -ground_.n, Vector3d::Zero(), Vector3d::Zero();
    region.field.linear = true;
    AddRegion(region, patch_);
    if (jacobian_ != nullptr) AddRegionJacobian(region, {}, jacobian_);
  }

  void AddSide() {
    const Vector3d& a = cylinder_.direction;
    const double upright = ground_.n.dot(a);
    const Vector3d level = ground_.n.cross(a);
    const double across = level.norm();
    // The normal that points up most, and the level one.
    level_ = across > 1e-12 ? Vector3d(level / across) : Vector3d(a.unitOrthogonal());
    up_ = a.cross(level_);
    const double r = cylinder_.radius;
    const double H = cylinder_.half_length;
    // Angles from up_, within [0, π], at which the line's ends lie on the plane.
    std::array<double, 4> breaks = {0.0, std::numbers::pi, std::numbers::pi, std::numbers::pi};
    int count = 1;
    for (const double end : {1.0, -1.0}) {
      const double height = ground_.CalcHeight(cylinder_.center) + end * H * upright;
      const double swing = r * ground_.n.dot(up_);
      if (std::abs(height) < swing) breaks[count++] = std::acos(-height / swing);
    }
    std::sort(breaks.begin(), breaks.end());
    for (int k = 0; k < 3; ++k) {
      const double length = breaks[k + 1] - breaks[k];
      const int pieces = static_cast<int>(std::ceil(length / kLongestPiece));
      for (int i = 0; i < pieces; ++i) {
        const double half = 0.5 * length / pieces;
        const double middle = breaks[k] + (2 * i + 1) * half;
        for (int g = 0; g < 8; ++g) {
          const double angle = middle + (g < 4 ? -half : half) * kArcAt[g % 4];
          const double weight = half * kArcWeight[g % 4] * r;
          AddLine(std::cos(angle), std::sin(angle), weight);
          AddLine(std::cos(angle), -std::sin(angle), weight);
        }
      }
    }
  }

  void AddLine(double cosine, double sine, double width) {
    const Vector3d n = cosine * up_ + sine * level_;
    const Vector3d middle = cylinder_.center + cylinder_.radius * n;
    const double height = ground_.CalcHeight(middle);
    const double slope = ground_.n.dot(cylinder_.direction);
    double begin = -cylinder_.half_length;
    double end = cylinder_.half_length;
    // Below the plane: height + slope s < 0.
    if (std::abs(slope) * cylinder_.half_length <= std::abs(height)) {
      if (height >= 0.0) return;
    } else if (slope > 0.0) {
      end = -height / slope;
    } else {
      begin = -height / slope;
    }
    const double half = 0.5 * (end - begin);
    for (const double at : {-kLineAt, kLineAt}) {
      Add(middle + (begin + half * (1.0 + at)) * cylinder_.direction, n, width * half);
    }
  }

  void Add(const Vector3d& x, const Vector3d& n, double dA) {
    const double e_dA = -ground_.CalcHeight(x) * dA;
    patch_->F -= e_dA * n;
    patch_->M -= e_dA * x.cross(n);
    patch_->W += e_dA;
    patch_->m1 += e_dA * x;
    patch_->m2 += e_dA * x * x.transpose();
    if (jacobian_ == nullptr) return;
    // How e moves with the cylinder; FinishJacobian turns and shifts what it presses on.
    Eigen::Matrix<double, 1, 6> rate;
    rate << -x.cross(ground_.n).transpose(), -ground_.n.transpose();
    rate *= dA;
    jacobian_->topRows<3>().noalias() -= n * rate;
    jacobian_->middleRows<3>(3).noalias() -= x.cross(n) * rate;
    jacobian_->row(6) += rate;
    jacobian_->middleRows<3>(7).noalias() += x * rate;
    for (int i = 0; i < 6; ++i) {
      const auto& [row, column] = PatchIntegrals::kPairs[i];
      jacobian_->row(10 + i) += x(row) * x(column) * rate;
    }
  }

  const SolidCylinder& cylinder_;
  const FieldPlane& ground_;
  PatchIntegrals* patch_;
  PatchJacobian* jacobian_;
  Vector3d up_, level_;
};

}  // namespace

void CalcCylinder(const SolidCylinder& cylinder, const FieldPlane& ground, PatchIntegrals* patch,
                  PatchJacobian* jacobian) {
  *patch = PatchIntegrals{};
  if (jacobian != nullptr) jacobian->setZero();
  const double reach = cylinder.half_length * std::abs(ground.n.dot(cylinder.direction)) +
                       cylinder.radius * ground.n.cross(cylinder.direction).norm();
  const double height = ground.CalcHeight(cylinder.center);
  if (height - reach >= 0.0) return;
  CylinderSum(cylinder, ground, patch, jacobian).Run();
  patch->depth = reach - height;
}

}  // namespace knap
