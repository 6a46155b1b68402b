// When a ball that approaches a surface will touch it, and how that time depends on the state it is seen from.
//
//   tau = t − g / gdot          g the gap, gdot < 0 its rate, at the state
//   dtau = −dg/gdot + g dgdot/gdot²
//
// g is the ball's distance from the nearest point p of the surface; in dgdot, p and the normal there stay as they are,
// which is exact on planes and off by the curvature times g elsewhere: tau says where the nodes of the time grid go,
// and any law for them that is the same in all derivatives will do.
#pragma once

#include <Eigen/Dense>
#include <array>
#include <optional>
#include <utility>
#include <vector>

#include "sim/contact/contact_side.h"
#include "sim/integrators/state_cotangent.h"
#include "sim/multibody/dynamics.h"

namespace knap {

// Slower than this nothing touches down: a gap that closes slowly has no time of its own [m/s].
inline constexpr double kLeastApproach = 1e-3;

struct Touchdown {
  double in = 0.0;                       // tau − t [s]
  std::array<StateCotangent, 2> bodies;  // ∂tau/∂(motions of both); their state is left at 0
  // ∂tau/∂vertices of the contact's designed mesh, in its body; none without one
  std::vector<std::pair<int, Eigen::Vector3d>> vertices;
};

// Of a ball against anything. None for other pairs, where the two overlap, or where the gap does not close.
std::optional<Touchdown> FindTouchdown(const ContactPair& contact, const std::vector<BodyKinematics>& kinematics);

}  // namespace knap
