// Prescribed motions of a joint, with exact rates and accelerations.
#pragma once

#include <Eigen/Dense>

#include "sim/multibody/tree.h"

namespace knap {

// x(t) = A asin(k sin(2πt/T)) / asin(k): a sine for k → 0, a triangle wave for k → 1; y(t) = min(speed t, stop_at).
struct Zigzag {
  double amplitude = 0.0;      // A [m]
  double period = 1.0;         // T [s]
  double sharpness = 0.95;     // k in (0, 1)
  double forward_speed = 0.0;  // [m/s]
  double stop_at = 0.0;        // [m]
};
PrescribedState CalcZigzag(const Zigzag& motion, double time);

// p = velocity t, R = Exp(angular_velocity t), both in F.
PrescribedState CalcConstantVelocity(const Eigen::Vector3d& velocity_F, const Eigen::Vector3d& angular_velocity_F,
                                     double time);

}  // namespace knap
