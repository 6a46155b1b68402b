// Spatial (6-D) vectors, angular part first, expressed in and about the origin of the frame that the name ends with.
//
// Twist V = [w; v], wrench F = [moment; force]. For a child frame B with pose X_PB = (R, p) in its parent P:
//   ShiftTwist:   V_B = X V_P       = [Rᵀw; Rᵀ(v + w × p)]
//   ShiftWrench:  F_P = Xᵀ F_B      = [R m + p × R f; R f]
// Cross products [Featherstone 2008, §2.9]: crm(V) = [w× 0; v× w×], crf(V) = −crm(V)ᵀ, and crf(V) F = CrossBar(F) V.
#pragma once

#include "sim/math/pose.h"
#include "sim/math/so3.h"

namespace knap {

inline Vector6d ShiftTwist(const Pose& X_PB, const Vector6d& V_P) {
  Vector6d V_B;
  V_B.head<3>() = X_PB.R.transpose() * V_P.head<3>();
  V_B.tail<3>() = X_PB.R.transpose() * (V_P.tail<3>() + V_P.head<3>().cross(X_PB.p));
  return V_B;
}

inline Vector6d ShiftWrench(const Pose& X_PB, const Vector6d& F_B) {
  Vector6d F_P;
  F_P.tail<3>() = X_PB.R * F_B.tail<3>();
  F_P.head<3>() = X_PB.R * F_B.head<3>() + X_PB.p.cross(F_P.tail<3>());
  return F_P;
}

// The inverse of ShiftTwist: V_P = X⁻¹ V_B.
inline Vector6d ShiftTwistBack(const Pose& X_PB, const Vector6d& V_B) {
  Vector6d V_P;
  V_P.head<3>() = X_PB.R * V_B.head<3>();
  V_P.tail<3>() = X_PB.R * V_B.tail<3>() + X_PB.p.cross(V_P.head<3>());
  return V_P;
}

// The 6×6 matrix X of ShiftTwist; its transpose is that of ShiftWrench.
inline Matrix6d TwistMatrix(const Pose& X_PB) {
  Matrix6d X;
  X.topLeftCorner<3, 3>() = X_PB.R.transpose();
  X.topRightCorner<3, 3>().setZero();
  X.bottomLeftCorner<3, 3>() = -X_PB.R.transpose() * Skew(X_PB.p);
  X.bottomRightCorner<3, 3>() = X_PB.R.transpose();
  return X;
}

inline Vector6d CrossMotion(const Vector6d& V, const Vector6d& U) {
  Vector6d r;
  r.head<3>() = V.head<3>().cross(U.head<3>());
  r.tail<3>() = V.tail<3>().cross(U.head<3>()) + V.head<3>().cross(U.tail<3>());
  return r;
}

inline Vector6d CrossForce(const Vector6d& V, const Vector6d& F) {
  Vector6d r;
  r.head<3>() = V.head<3>().cross(F.head<3>()) + V.tail<3>().cross(F.tail<3>());
  r.tail<3>() = V.head<3>().cross(F.tail<3>());
  return r;
}

inline Matrix6d CrossMotionMatrix(const Vector6d& V) {
  Matrix6d m;
  m.topLeftCorner<3, 3>() = Skew(V.head<3>());
  m.topRightCorner<3, 3>().setZero();
  m.bottomLeftCorner<3, 3>() = Skew(V.tail<3>());
  m.bottomRightCorner<3, 3>() = m.topLeftCorner<3, 3>();
  return m;
}

// CrossBar(F) V = crf(V) F.
inline Matrix6d CrossBarMatrix(const Vector6d& F) {
  Matrix6d m;
  m.topLeftCorner<3, 3>() = -Skew(F.head<3>());
  m.topRightCorner<3, 3>() = -Skew(F.tail<3>());
  m.bottomLeftCorner<3, 3>() = m.topRightCorner<3, 3>();
  m.bottomRightCorner<3, 3>().setZero();
  return m;
}

}  // namespace knap
