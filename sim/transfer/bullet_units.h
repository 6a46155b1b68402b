// Between knap's vectors in metres and Bullet's in centimetres: Bullet's fixed tolerances are made for bodies of about
// one unit, and ours measure centimetres. Masses and times are the same in both, so that
//
//   velocity, force, impulse × 100;   inertia, torque × 10⁴
#pragma once

#include <LinearMath/btTransform.h>

#include <Eigen/Core>

#include "sim/math/pose.h"

namespace knap {

inline constexpr double kUnitsPerMetre = 100.0;

inline btVector3 ToBullet(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }
inline btVector3 ToUnits(const Eigen::Vector3d& v) { return ToBullet(kUnitsPerMetre * v); }
inline Eigen::Vector3d FromBullet(const btVector3& v) { return {v.x(), v.y(), v.z()}; }
inline Eigen::Vector3d FromUnits(const btVector3& v) { return FromBullet(v) / kUnitsPerMetre; }

inline btMatrix3x3 ToBullet(const Eigen::Matrix3d& R) {
  return {R(0, 0), R(0, 1), R(0, 2), R(1, 0), R(1, 1), R(1, 2), R(2, 0), R(2, 1), R(2, 2)};
}
inline Eigen::Matrix3d FromBullet(const btMatrix3x3& R) {
  Eigen::Matrix3d out;
  for (int i = 0; i < 3; ++i) out.row(i) = FromBullet(R.getRow(i)).transpose();
  return out;
}

inline btTransform ToUnits(const Pose& X) { return btTransform(ToBullet(X.R), ToUnits(X.p)); }
inline Pose FromUnits(const btTransform& X) { return {FromBullet(X.getBasis()), FromUnits(X.getOrigin())}; }

}  // namespace knap
