#include "sim/contact/axis_integrals.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace knap {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

constexpr std::array<double, 4> kAt = {0.0694318442029737, 0.3300094782075719, 0.6699905217924281, 0.9305681557970263};
constexpr std::array<double, 4> kWeight = {0.1739274225687269, 0.3260725774312731, 0.3260725774312731,
                                           0.1739274225687269};

// The widened field at one place.
struct Widened {
  double e;
  Vector3d gradient;
  Matrix3d hessian;
  Vector3d contact;     // x_C
  Matrix3d contact_dx;  // its derivative in x
};

// An energy's slope and curvature in e.
struct Slope {
  double first;
  double second;
};

class AxisSum {
 public:
  AxisSum(const RoundAxis& axis, const DepthField& field, PatchIntegrals* patch, PatchJacobian* jacobian)
      : axis_(axis), round_(std::get_if<RoundField>(&field)), patch_(patch), jacobian_(jacobian) {
    if (round_ == nullptr) plane_ = &std::get<PolyhedralField>(field).planes.front();
    rho_ = round_ == nullptr ? axis.radius : axis.radius + round_->radius;
    narrower_ = round_ == nullptr ? axis.radius : std::min(axis.radius, round_->radius);
    reduced_ = round_ == nullptr ? axis.radius : axis.radius * round_->radius / rho_;
  }

  void Run() {
    if (axis_.half_length > 0.0) {
      // Where the nearest point of S's axis stops being an end of it.
      std::array<double, 4> breaks = {-axis_.half_length, axis_.half_length, axis_.half_length, axis_.half_length};
      if (round_ != nullptr) {
        const double slope = round_->axis.dot(axis_.direction);
        const double at = round_->axis.dot(axis_.center - round_->center);
        if (slope != 0.0) {
          double low = (-round_->half_length - at) / slope;
          double high = (round_->half_length - at) / slope;
          if (low > high) std::swap(low, high);
          breaks[1] = std::clamp(low, -axis_.half_length, axis_.half_length);
          breaks[2] = std::clamp(high, -axis_.half_length, axis_.half_length);
        }
      }
      for (int k = 0; k < 3; ++k) AddPiece(breaks[k], breaks[k + 1]);
    }
    for (const double end : {-1.0, 1.0}) {
      const Widened at = Evaluate(axis_.center + end * axis_.half_length * axis_.direction);
      if (at.e > 0.0) Add(axis_.center + end * axis_.half_length * axis_.direction, at, CalcEnd(at.e), 0.5);
    }
  }

 private:
  // e is quadratic between the breakpoints, and positive on one interval: three values tell which.
  void AddPiece(double begin, double end) {
    const double length = end - begin;
    if (!(length > 0.0)) return;
    const auto e = [&](double t) { return Evaluate(axis_.center + (begin + t * length) * axis_.direction).e; };
    const double e0 = e(0.0);
    const double e1 = e(1.0);
    const double bend = 2.0 * (e0 + e1 - 2.0 * e(0.5));  // of e0 + slope t + bend t²
    const double slope = e1 - e0 - bend;
    double t0 = 0.0;
    double t1 = 1.0;
    if (!(e0 > 0.0 && e1 > 0.0)) {
      // At least one end is clear: roots, the one without cancellation first. Rounding may leave a flat e bent upwards.
      const double half = -0.5 * slope;
      const double discriminant = half * half - std::min(bend, 0.0) * e0;
      if (!(discriminant > 0.0)) return;
      const double big = half + std::copysign(std::sqrt(discriminant), half);
      double low = big == 0.0 ? 0.0 : e0 / big;
      double high = bend < 0.0 ? big / bend : (low > 0.0 && e0 > 0.0 ? -1.0 : 2.0);
      if (low > high) std::swap(low, high);
      t0 = std::max(t0, low);
      t1 = std::min(t1, high);
    }
    for (int g = 0; g < 4 && t1 > t0; ++g) {
      const double t = t0 + (t1 - t0) * kAt[g];
      const Vector3d x = axis_.center + (begin + t * length) * axis_.direction;
      const Widened at = Evaluate(x);
      Add(x, at, {2.0 * narrower_ * at.e, 2.0 * narrower_}, kWeight[g] * (t1 - t0) * length);
    }
  }

  Slope CalcEnd(double e) const {
    const double pi = std::numbers::pi;
    if (round_ != nullptr) return {pi * reduced_ * e * e, 2.0 * pi * reduced_ * e};
    const double r = axis_.radius;
    if (e >= 2.0 * r) return {4.0 / 3.0 * pi * r * r * r, 0.0};
    return {pi * e * e * (r - e / 3.0), pi * e * (2.0 * r - e)};
  }

  Widened Evaluate(const Vector3d& x) const {
    Widened out;
    if (round_ == nullptr) {
      const double height = plane_->CalcHeight(x);
      out.e = axis_.radius - height;
      out.gradient = -plane_->n;
      out.hessian.setZero();
      out.contact_dx = Matrix3d::Identity() - plane_->n * plane_->n.transpose();
      out.contact = x - height * plane_->n;
      return out;
    }
    const double along = round_->axis.dot(x - round_->center);
    const bool interior = std::abs(along) < round_->half_length;
    const double s = std::clamp(along, -round_->half_length, round_->half_length);
    const Vector3d y = round_->center + s * round_->axis;
    const Vector3d d = x - y;
    Matrix3d dy_dx = Matrix3d::Zero();
    if (interior) dy_dx = round_->axis * round_->axis.transpose();
    out.e = (rho_ * rho_ - d.squaredNorm()) / (2.0 * rho_);
    out.gradient = -d / rho_;
    out.hessian = (dy_dx - Matrix3d::Identity()) / rho_;
    out.contact = (round_->radius * x + axis_.radius * y) / rho_;
    out.contact_dx = (round_->radius * Matrix3d::Identity() + axis_.radius * dy_dx) / rho_;
    return out;
  }

  // One place of the axis, with a share of the sum.
  void Add(const Vector3d& x, const Widened& at, const Slope& energy, double share) {
    const Vector3d f = -share * energy.first * at.gradient;
    const double weight = share * energy.first;
    const Vector3d& c = at.contact;
    // The spot of a ball of radius R pressed in by e spreads by a²/3, a² = 2 R e, all directions together.
    const double spread = 2.0 / 9.0 * reduced_;
    patch_->F += f;
    patch_->M += x.cross(f);
    patch_->W += weight;
    patch_->m1 += weight * c;
    patch_->m2 += weight * (c * c.transpose() + spread * at.e * Matrix3d::Identity());
    patch_->depth = std::max(patch_->depth, at.e);
    if (jacobian_ == nullptr) return;
    for (int k = 0; k < 6; ++k) {
      const Vector3d dx = k < 3 ? Vector3d(Vector3d::Unit(k).cross(x)) : Vector3d(Vector3d::Unit(k - 3));
      const double de = at.gradient.dot(dx);
      const Vector3d df = -share * (energy.second * de * at.gradient + energy.first * (at.hessian * dx));
      const double d_weight = share * energy.second * de;
      const Vector3d dc = at.contact_dx * dx;
      jacobian_->col(k).segment<3>(0) += df;
      jacobian_->col(k).segment<3>(3) += dx.cross(f) + x.cross(df);
      (*jacobian_)(6, k) += d_weight;
      jacobian_->col(k).segment<3>(7) += d_weight * c + weight * dc;
      const Matrix3d turned = dc * c.transpose();
      AddSymmetric(d_weight * (c * c.transpose() + spread * at.e * Matrix3d::Identity()) +
                       weight * (turned + turned.transpose() + spread * de * Matrix3d::Identity()),
                   k, jacobian_);
    }
  }

  const RoundAxis& axis_;
  const RoundField* round_;  // or
  const FieldPlane* plane_ = nullptr;
  PatchIntegrals* patch_;
  PatchJacobian* jacobian_;
  double rho_;
  double reduced_;   // R
  double narrower_;  // b
};

}  // namespace

void CalcAxis(const RoundAxis& axis, const DepthField& field, PatchIntegrals* patch, PatchJacobian* jacobian) {
  *patch = PatchIntegrals{};
  if (jacobian != nullptr) jacobian->setZero();
  AxisSum(axis, field, patch, jacobian).Run();
}

}  // namespace knap
