// Rotations: the exponential map of SO(3) and its right Jacobian.
//
//   R(q ⊕ phi) = R(q) · Exp(phi),        phi in the moving frame, |phi| < π
//   Exp(phi + delta) ≈ Exp(phi) · Exp(Jr(phi) · delta)
//   Jr(phi) = I − (1 − cos a)/a² [phi]× + (a − sin a)/a³ [phi]×²,   a = |phi|      [Solà 2018, Eq. 143]
#pragma once

#include <Eigen/Geometry>
#include <cmath>

namespace knap {

// [v]× with [v]× w = v × w.
inline Eigen::Matrix3d Skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0.0, -v.z(), v.y(),  //
      v.z(), 0.0, -v.x(),   //
      -v.y(), v.x(), 0.0;
  return m;
}

// Unit quaternion of the rotation by |phi| about phi. Exact to rounding for every |phi|, smooth through 0.
inline Eigen::Quaterniond ExpSo3(const Eigen::Vector3d& phi) {
  const double a2 = phi.squaredNorm();
  double w = 0.0;
  double s = 0.0;  // sin(a/2)/a
  if (a2 < 1e-8) {
    // Below this the next Taylor terms are under 1e-17.
    w = 1.0 - a2 / 8.0 + a2 * a2 / 384.0;
    s = 0.5 - a2 / 48.0 + a2 * a2 / 3840.0;
  } else {
    const double a = std::sqrt(a2);
    w = std::cos(0.5 * a);
    s = std::sin(0.5 * a) / a;
  }
  return Eigen::Quaterniond(w, s * phi.x(), s * phi.y(), s * phi.z());
}

// The right Jacobian Jr(phi) of the header's equation.
inline Eigen::Matrix3d RightJacobianSo3(const Eigen::Vector3d& phi) {
  const double a2 = phi.squaredNorm();
  double b = 0.0;  // (1 − cos a)/a²
  double c = 0.0;  // (a − sin a)/a³
  if (a2 < 1e-4) {
    // Three terms leave an error under 1e-17 here, where the closed forms would cancel.
    b = 0.5 - a2 / 24.0 + a2 * a2 / 720.0 - a2 * a2 * a2 / 40320.0;
    c = 1.0 / 6.0 - a2 / 120.0 + a2 * a2 / 5040.0 - a2 * a2 * a2 / 362880.0;
  } else {
    const double a = std::sqrt(a2);
    b = (1.0 - std::cos(a)) / a2;
    c = (a - std::sin(a)) / (a2 * a);
  }
  // [phi]×² = phi phiᵀ − a² I.
  Eigen::Matrix3d Jr = c * phi * phi.transpose() - Skew(b * phi);
  Jr.diagonal().array() += 1.0 - c * a2;
  return Jr;
}

}  // namespace knap
