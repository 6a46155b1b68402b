#include "sim/multibody/motions.h"

#include <cmath>
#include <numbers>

#include "sim/math/spatial.h"

namespace knap {

namespace {

// The share done of a piece, its rate and acceleration.
struct Share {
  double s = 0.0;
  double rate = 0.0;          // [1/s]
  double acceleration = 0.0;  // [1/s²]
  double jerk = 0.0;          // [1/s³]
};

Share CalcShare(const MotionPiece& piece, double time) {
  const double T = piece.duration;
  const double r = piece.ramp;
  if (time >= T) return {1.0, 0.0, 0.0, 0.0};
  if (time > T - r) {
    const Share left = CalcShare(piece, T - time);
    return {1.0 - left.s, left.rate, -left.acceleration, left.jerk};
  }
  const double full = 1.0 / (T - r);
  if (time >= r) return {full * (time - 0.5 * r), full, 0.0, 0.0};
  const double x = time / r;
  return {full * r * x * x * x * (1.0 - 0.5 * x), full * x * x * (3.0 - 2.0 * x), full / r * 6.0 * x * (1.0 - x),
          full / (r * r) * 6.0 * (1.0 - 2.0 * x)};
}

}  // namespace

PrescribedState CalcZigzag(const Zigzag& motion, double time) {
  const double omega = 2.0 * std::numbers::pi / motion.period;
  const double k = motion.sharpness;
  const double s = std::sin(omega * time);
  const double c = std::cos(omega * time);
  const double scale = motion.amplitude / std::asin(k);
  const double root = std::sqrt(1.0 - k * k * s * s);
  PrescribedState state;
  state.X_FB.p.x() = scale * std::asin(k * s);
  state.V(3) = scale * k * omega * c / root;
  state.A(3) = scale * k * omega * omega * s * (k * k * c * c / (root * root) - 1.0) / root;
  const double root2 = root * root;
  state.jerk(3) =
      -scale * k * (1.0 - k * k) * omega * omega * omega * c * (1.0 + 2.0 * k * k * s * s) / (root2 * root2 * root);
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
  state.jerk.tail<3>() = -angular_velocity_F.cross(state.A.tail<3>());
  return state;
}

PrescribedState CalcPieces(const std::vector<MotionPiece>& pieces, double time) {
  PrescribedState state;
  double begin = 0.0;
  for (const MotionPiece& piece : pieces) {
    if (time <= begin) break;
    const Share share = CalcShare(piece, time - begin);
    const Eigen::Quaterniond turned = ExpSo3(share.s * piece.turn);
    state.X_FB.p += share.s * piece.shift;
    state.X_FB.R = turned.toRotationMatrix() * state.X_FB.R;
    const Eigen::Matrix3d R_BF = state.X_FB.R.transpose();
    const Eigen::Vector3d w_B = R_BF * piece.turn;  // constant in F, and the turn's own axis: so in B too
    const Eigen::Vector3d v_B = R_BF * piece.shift;
    state.V.head<3>() = share.rate * w_B;
    state.V.tail<3>() = share.rate * v_B;
    state.A.head<3>() = share.acceleration * w_B;
    const Eigen::Vector3d turned_v = w_B.cross(v_B);
    const double rate2 = share.rate * share.rate;
    state.A.tail<3>() = share.acceleration * v_B - rate2 * turned_v;
    state.jerk.head<3>() = share.jerk * w_B;
    state.jerk.tail<3>() =
        share.jerk * v_B - 3.0 * share.rate * share.acceleration * turned_v + rate2 * share.rate * w_B.cross(turned_v);
    begin += piece.duration;
  }
  return state;
}

PrescribedState CalcTurn(const Eigen::Vector3d& axis_F, const CubicSpline::Value& angle) {
  PrescribedState state;
  state.X_FB.R = ExpSo3(angle.x * axis_F).toRotationMatrix();
  // The axis is the same in F and B.
  state.V.head<3>() = angle.rate * axis_F;
  state.A.head<3>() = angle.acceleration * axis_F;
  state.jerk.head<3>() = angle.jerk * axis_F;
  return state;
}

PrescribedState CalcShift(const Eigen::Vector3d& axis_F, const CubicSpline::Value& displacement) {
  PrescribedState state;
  state.X_FB.p = displacement.x * axis_F;
  state.V.tail<3>() = displacement.rate * axis_F;
  state.A.tail<3>() = displacement.acceleration * axis_F;
  state.jerk.tail<3>() = displacement.jerk * axis_F;
  return state;
}

PrescribedState Compose(const PrescribedState& M_in_F, const PrescribedState& B_in_M) {
  const Vector6d V = ShiftTwist(B_in_M.X_FB, M_in_F.V);
  const Vector6d A = ShiftTwist(B_in_M.X_FB, M_in_F.A);
  const Vector6d turned = A - CrossMotion(B_in_M.V, V);  // d(Y V_M)/dt
  PrescribedState state;
  state.X_FB = M_in_F.X_FB * B_in_M.X_FB;
  state.V = V + B_in_M.V;
  state.A = turned + B_in_M.A;
  state.jerk = ShiftTwist(B_in_M.X_FB, M_in_F.jerk) - CrossMotion(B_in_M.V, A) - CrossMotion(B_in_M.A, V) -
               CrossMotion(B_in_M.V, turned) + B_in_M.jerk;
  return state;
}

}  // namespace knap
