#include "sim/multibody/motions.h"

#include <cmath>

namespace knap {

PrescribedState CalcZigzag(const Zigzag& motion, double time) {
  constexpr double kTwoPi = 6.283185307179586476925286766559;
  const double omega = kTwoPi / motion.period;
  const double k = motion.sharpness;
  const double s = std::sin(omega * time);
  const double c = std::cos(omega * time);
  const double scale = motion.amplitude / std::asin(k);
  const double root = std::sqrt(1.0 - k * k * s * s);
  PrescribedState state;
  state.X_FB.p.x() = scale * std::asin(k * s);
  state.V(3) = scale * k * omega * c / root;
  state.A(3) = scale * k * omega * omega * s * (k * k * c * c / (root * root) - 1.0) / root;
  const bool moving = motion.forward_speed * time < motion.stop_at;
  state.X_FB.p.y() = moving ? motion.forward_speed * time : motion.stop_at;
  state.V(4) = moving ? motion.forward_speed : 0.0;
  return state;
}

PrescribedState CalcConstantVelocity(const Eigen::Vector3d& velocity_F, const Eigen::Vector3d& angular_velocity_F,
                                     double time) {
  PrescribedState state;
  state.X_FB.R = ExpSo3(angular_velocity_F * time).toRotationMatrix();
  state.X_FB.p = velocity_F * time;
  const Eigen::Vector3d v_B = state.X_FB.R.transpose() * velocity_F;
  state.V.head<3>() = angular_velocity_F;  // its own axis: the same in F and B
  state.V.tail<3>() = v_B;
  state.A.tail<3>() = -angular_velocity_F.cross(v_B);  // the components in B turn under the constant vector
  return state;
}

}  // namespace knap
