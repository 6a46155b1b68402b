// Prescribed motions of a joint, with exact rates and accelerations.
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "sim/math/cubic_spline.h"
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

// One piece of a motion: a shift and a turn about Bo in step, from rest to rest. Their share s of the whole rises with
// the speed v(τ) = ramp(τ/r)/(T − r), ramp(x) = 3x² − 2x³ over the first time r, one in between, and back over the
// last.
struct MotionPiece {
  double duration = 0.0;                            // T [s], > 0
  double ramp = 0.0;                                // r [s], 0 < r ≤ T/2
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();  // in F [m]
  Eigen::Vector3d turn = Eigen::Vector3d::Zero();   // about its direction, fixed in F, by its length [rad]
};
// One after the other from F, and then still.
PrescribedState CalcPieces(const std::vector<MotionPiece>& pieces, double time);

// A turn about the unit vector `axis` by as many radians, or a shift along it by as many metres, as a spline says.
PrescribedState CalcTurn(const Eigen::Vector3d& axis_F, const CubicSpline::Value& angle);
PrescribedState CalcShift(const Eigen::Vector3d& axis_F, const CubicSpline::Value& displacement);

// What moves in what moves: of B in F, of M in F and of B in M. With Y the matrix of X_BM, which takes twists to B,
//   V = Y V_M + V_B    and    d(Y U)/dt = Y dU/dt − V_B × Y U.
PrescribedState Compose(const PrescribedState& M_in_F, const PrescribedState& B_in_M);

}  // namespace knap
