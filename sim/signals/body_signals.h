// What a body does, seen in the world or from another body A:
//
//   position           e_A · p_AoP_A of a point P of body B along an axis e_A
//   velocity           e · v_WP_W
//   direction          e_A · R_AB f_B: a component in A of an axis f of B, an entry of the rotation matrix
//   angular velocity   e · w_WB_W
//   distance           ‖p_AoP_A − target_A(t)‖; its gradient is zero where P is on the target
//
// Rotations are seen as entries of their matrix alone: these have neither singularities nor a sign to choose, as angles
// and quaternions would.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "sim/signals/signal_function.h"

namespace knap {

// A point of a body; `number` is its place among the rollout's watched points.
struct WatchedPoint {
  int body = 0;
  Eigen::Vector3d p_B = Eigen::Vector3d::Zero();
  int number = 0;
};

inline constexpr int kWorldFrame = -1;

// Axes are unit vectors; `in` is a body or kWorldFrame.
std::unique_ptr<SignalFunction> MakePositionSignal(const WatchedPoint& point, int in, const Eigen::Vector3d& axis_A);
std::unique_ptr<SignalFunction> MakeVelocitySignal(const WatchedPoint& point, const Eigen::Vector3d& axis_W);
std::unique_ptr<SignalFunction> MakeDirectionSignal(int body, const Eigen::Vector3d& of_axis_B, int in,
                                                    const Eigen::Vector3d& axis_A);
std::unique_ptr<SignalFunction> MakeAngularVelocitySignal(int body, const Eigen::Vector3d& axis_W);

// Counts after its time; the first of a list always does. Ascending.
struct TimedPoint {
  double after = 0.0;
  Eigen::Vector3d p_A = Eigen::Vector3d::Zero();
};
std::unique_ptr<SignalFunction> MakeDistanceSignal(const WatchedPoint& point, int in, std::vector<TimedPoint> targets);

}  // namespace knap
