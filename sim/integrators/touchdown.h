// When a ball that approaches a surface will touch it, and how that time depends on the state it is seen from.
//
//   tau = t − g / gdot          g the gap, gdot < 0 its rate, at the state
//   dtau = −dg/gdot + g dgdot/gdot²
//
// g is the ball's distance from the nearest point p of the surface. In dtau, p and the normal there stay as they are:
// tau says where the nodes of the time grid go, and any law for them that is the same in all derivatives will do. The
// law is then tau of an Approach, which holds them; at its own state it is that of g.
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

// What of two bodies comes near what of the other.
struct Approach {
  int ball = 0;                                   // which of the contact's two shapes is one
  Eigen::Vector3d n_W = Eigen::Vector3d::Zero();  // from p to the ball's centre
  Eigen::Vector3d p_S = Eigen::Vector3d::Zero();  // of the other shape's core, in its body [m]; or, of a mesh,
  int triangle = -1;                              // on which of its triangles …
  Eigen::Vector3d barycentric = Eigen::Vector3d::Zero();
  double inflation = 0.0;  // of the core [m]
};

struct Touchdown {
  double in = 0.0;  // tau − t [s]
  Approach approach;
  std::array<StateCotangent, 2> bodies;  // ∂tau/∂(motions of both); their state is left at 0
  // ∂tau/∂vertices of the contact's designed mesh, in its body; none without one
  std::vector<std::pair<int, Eigen::Vector3d>> vertices;
};

// Of a ball against anything. None for other pairs, where the two overlap, or where the gap does not close.
std::optional<Touchdown> FindTouchdown(const ContactPair& contact, const std::vector<BodyKinematics>& kinematics);

// tau − t of an approach that another trajectory showed, whatever the gap's sign; none where it does not close [s].
std::optional<double> CalcTouchdownIn(const Approach& approach, const ContactPair& contact,
                                      const std::vector<BodyKinematics>& kinematics);

}  // namespace knap
