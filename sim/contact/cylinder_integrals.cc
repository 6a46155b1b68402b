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
  CylinderSum(const SolidCylinder& cylinder, PatchIntegrals* patch, PatchJacobian* jacobian)
      : cylinder_(cylinder), patch_(patch), jacobian_(jacobian) {}

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
    const Vector3d level = Vector3d::UnitZ().cross(f.n);
    f.m = level.norm() > 1e-12 ? Vector3d(level.normalized()) : f.n.unitOrthogonal();
    f.t = f.m.cross(f.n);
    const double slope = f.t.z();  // e = −(o.z + slope u)
    double low = -r;
    double high = r;
    if (std::abs(slope) * r <= std::abs(f.o.z())) {
      if (f.o.z() > 0.0) return;
    } else if (slope > 0.0) {
      high = -f.o.z() / slope;
    } else {
      low = -f.o.z() / slope;
    }
    const std::array<Eigen::Vector2d, 4> polygon = {Eigen::Vector2d(low, -r), Eigen::Vector2d(high, -r),
                                                    Eigen::Vector2d(high, r), Eigen::Vector2d(low, r)};
    region.moments = CalcConicMoments(polygon, Conic::Around(r * r, 1.0, 0.0));
    if (!(region.moments.area() > 0.0)) return;
    region.field.e << -f.o.z(), -slope, -f.m.z(), 0.0, 0.0, 0.0;  // m is level up to rounding, or e is all but even
    region.field.gradient << -Vector3d::UnitZ(), Vector3d::Zero(), Vector3d::Zero();
    region.field.linear = true;
    AddRegion(region, patch_);
    if (jacobian_ != nullptr) AddRegionJacobian(region, {}, jacobian_);
  }

  void AddSide() {
    const Vector3d& a = cylinder_.direction;
    const double upright = a.z();
    const double across = std::hypot(a.x(), a.y());
    // The normal that points up most, and the level one.
    level_ = across > 1e-12 ? Vector3d(Vector3d::UnitZ().cross(a) / across) : Vector3d(a.unitOrthogonal());
    up_ = a.cross(level_);
    const double r = cylinder_.radius;
    const double H = cylinder_.half_length;
    // Angles from up_, within [0, π], at which the line's ends lie on the plane.
    std::array<double, 4> breaks = {0.0, std::numbers::pi, std::numbers::pi, std::numbers::pi};
    int count = 1;
    for (const double end : {1.0, -1.0}) {
      const double z = cylinder_.center.z() + end * H * upright;
      if (std::abs(z) < r * up_.z()) breaks[count++] = std::acos(-z / (r * up_.z()));
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
    const double slope = cylinder_.direction.z();
    double begin = -cylinder_.half_length;
    double end = cylinder_.half_length;
    // Below the plane: middle.z + slope s < 0.
    if (std::abs(slope) * cylinder_.half_length <= std::abs(middle.z())) {
      if (middle.z() >= 0.0) return;
    } else if (slope > 0.0) {
      end = -middle.z() / slope;
    } else {
      begin = -middle.z() / slope;
    }
    const double half = 0.5 * (end - begin);
    for (const double at : {-kLineAt, kLineAt}) {
      Add(middle + (begin + half * (1.0 + at)) * cylinder_.direction, n, width * half);
    }
  }

  void Add(const Vector3d& x, const Vector3d& n, double dA) {
    const double e_dA = -x.z() * dA;
    patch_->F -= e_dA * n;
    patch_->M -= e_dA * x.cross(n);
    patch_->W += e_dA;
    patch_->m1 += e_dA * x;
    patch_->m2 += e_dA * x * x.transpose();
    if (jacobian_ == nullptr) return;
    // How e moves with the cylinder; FinishJacobian turns and shifts what it presses on.
    Eigen::Matrix<double, 1, 6> rate;
    rate << x.cross(-Vector3d::UnitZ()).transpose(), -Vector3d::UnitZ().transpose();
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
  PatchIntegrals* patch_;
  PatchJacobian* jacobian_;
  Vector3d up_, level_;
};

}  // namespace

void CalcCylinder(const SolidCylinder& cylinder, PatchIntegrals* patch, PatchJacobian* jacobian) {
  *patch = PatchIntegrals{};
  if (jacobian != nullptr) jacobian->setZero();
  const double reach = cylinder.half_length * std::abs(cylinder.direction.z()) +
                       cylinder.radius * std::hypot(cylinder.direction.x(), cylinder.direction.y());
  if (cylinder.center.z() - reach >= 0.0) return;
  CylinderSum(cylinder, patch, jacobian).Run();
  patch->depth = reach - cylinder.center.z();
}

}  // namespace knap
