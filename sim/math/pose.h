// The pose of a frame in another, and the types of six-dimensional vectors: what headers need of spatial.h, which
// compiles its functions wherever it is included.
#pragma once

#include <Eigen/Dense>

namespace knap {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

// Pose of a frame B in a frame P: p_P = R · p_B + p.
struct Pose {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d p = Eigen::Vector3d::Zero();

  Pose operator*(const Pose& other) const { return {R * other.R, p + R * other.p}; }
  Eigen::Vector3d operator*(const Eigen::Vector3d& point) const { return R * point + p; }
  Eigen::Vector3d ApplyInverse(const Eigen::Vector3d& point) const { return R.transpose() * (point - p); }
};

}  // namespace knap
