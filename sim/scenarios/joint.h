// The joints of a scene (scene.h): how a body moves relative to its parent, what drives and holds it, and where it
// starts. Frames: P the parent body; J the joint frame, fixed in P; B the body frame. SI units.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace knap {

struct FixedJoint {};

// x(t) = A·asin(k·sin(2πt/T)) / asin(k), y(t) = min(forward_speed·t, stop_at), z = 0, no rotation, in J.
// k → 0 gives a sine, k → 1 a triangle wave; the lateral swing goes on after the forward motion has stopped.
struct ZigzagMotion {
  double amplitude = 0.0;      // A [m]
  double period = 1.0;         // T [s]
  double sharpness = 0.95;     // k [-], in (0, 1)
  double forward_speed = 0.0;  // [m/s]
  double stop_at = 0.0;        // y at which the forward motion ends [m]
};

// p_JB = velocity·t; R_JB turns about the fixed axis of angular_velocity at its constant rate.
struct ConstantVelocityMotion {
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();          // v_JB_J [m/s]
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();  // w_JB_J [rad/s]
};

// A shift and a turn about Bo in step, from rest to rest: the speed rises as a smooth step during `ramp`, is constant,
// and falls as it rose. A turn's axis is fixed in J: either `axis`, or the level one across `tips`, a direction in J
// that a full turn so carries through upright and upside down; up is against gravity, the axis's sense fixed in J.
struct MotionSegment {
  double duration = 0.0;                            // [s]
  double ramp = 0.0;                                // [s], at most half the duration
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();  // in J [m]
  double angle = 0.0;                               // [rad]
  Eigen::Vector3d axis = Eigen::Vector3d::Zero();   // in J, of any length; zero: not given
  Eigen::Vector3d tips = Eigen::Vector3d::Zero();   // likewise; where the angle is not zero, one of the two is given
};

// One segment after the other from J on, then still.
struct SegmentsMotion {
  std::vector<MotionSegment> segments;
};

// A cubic spline through the rows of a CSV file with the columns time [s], x, y, z [m], roll, pitch, yaw [rad]; at rest
// before the first row and after the last.
struct PathMotion {
  std::string file;
};

// Likewise one column of a file: an angle about an axis through Jo [rad], or a displacement along it [m].
enum class JointPathKind { kTurn, kShift };
struct JointPathMotion {
  std::string file;
  std::string column;
  JointPathKind kind = JointPathKind::kTurn;
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  // in J, not zero, of any length
};

using Motion = std::variant<ZigzagMotion, ConstantVelocityMotion, SegmentsMotion, PathMotion, JointPathMotion>;

// The pose of B in J is a given function of time.
struct PrescribedJoint {
  Motion motion;
};

// One-sided springs at the ends of a joint's range, which set in smoothly over `width` and push back alone
// (sim/multibody/joint_forces.h). Units: those of a torque or a force and of the joint's coordinate x.
struct JointLimits {
  double lower = 0.0;      // [rad, m]
  double upper = 0.0;      // > lower
  double stiffness = 0.0;  // [N·m/rad, N/m]
  double damping = 0.0;    // relative to the elastic force [s/rad, s/m]
  double width = 0.0;      // [rad, m]
};

// Force or torque limit·u.
struct ForceActuator {
  double limit = 0.0;  // [N·m, N]
};

// Draws the joint to a target, lower for u = −1 and upper for u = 1: limit·tanh(e/limit) with
// e = stiffness (target − x) − damping v.
struct PositionActuator {
  double limit = 0.0;      // [N·m, N]
  double stiffness = 0.0;  // [N·m/rad, N/m]
  double damping = 0.0;    // [N·m·s/rad, N·s/m]
  double lower = 0.0;      // [rad, m]
  double upper = 0.0;      // > lower
};

// Pushes the joint by its command u, −1 ≤ u ≤ 1 (Scene::controls); undriven, u = 0.
using JointActuator = std::variant<ForceActuator, PositionActuator>;

struct RevoluteState {
  double angle = 0.0;  // [rad]
  double rate = 0.0;   // [rad/s]
};

// One rotation about `axis` through Jo.
struct RevoluteJoint {
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  // in J, not zero, of any length
  double damping = 0.0;                             // [N·m·s/rad]
  double stiffness = 0.0;                           // of a spring towards `rest` [N·m/rad]
  double rest = 0.0;                                // [rad]
  std::optional<JointLimits> limits;
  std::optional<JointActuator> actuator;
  RevoluteState initial;
};

struct PrismaticState {
  double displacement = 0.0;  // [m]
  double speed = 0.0;         // [m/s]
};

// One translation along `axis`.
struct PrismaticJoint {
  Eigen::Vector3d axis = Eigen::Vector3d::UnitX();  // in J, not zero, of any length
  double damping = 0.0;                             // [N·s/m]
  double stiffness = 0.0;                           // of a spring towards `rest` [N/m]
  double rest = 0.0;                                // [m]
  std::optional<JointLimits> limits;
  std::optional<JointActuator> actuator;
  PrismaticState initial;
};

struct BallState {
  Eigen::Vector3d orientation_rpy = Eigen::Vector3d::Zero();   // of B in J [rad]
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();  // w_JB_J [rad/s]
};

// Three rotations about Jo.
struct BallJoint {
  double damping = 0.0;    // [N·m·s/rad], against w_JB
  double stiffness = 0.0;  // k of the energy k (1 − cos angle), the angle from `rest` [N·m/rad]
  Eigen::Vector3d rest_rpy = Eigen::Vector3d::Zero();  // orientation of B in J [rad]
  BallState initial;
};

struct PlanarState {
  Eigen::Vector2d position = Eigen::Vector2d::Zero();  // of Bo in J's xy-plane [m]
  double angle = 0.0;                                  // about Jz [rad]
  Eigen::Vector2d velocity = Eigen::Vector2d::Zero();  // in J [m/s]
  double angular_velocity = 0.0;                       // about Jz [rad/s]
};

// Translation in J's xy-plane and rotation about Jz.
struct PlanarJoint {
  double linear_damping = 0.0;   // [N·s/m]
  double angular_damping = 0.0;  // [N·m·s/rad]
  PlanarState initial;
};

struct FreeState {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();          // p_JB [m]
  Eigen::Vector3d orientation_rpy = Eigen::Vector3d::Zero();   // of B in J [rad]
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();          // v_JBo_J [m/s]
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();  // w_JB_J [rad/s]
};

struct FreeJoint {
  FreeState initial;
};

using JointKind =
    std::variant<FixedJoint, PrescribedJoint, RevoluteJoint, PrismaticJoint, BallJoint, PlanarJoint, FreeJoint>;

// The point of a designed parent with which a joint moves.
struct Attachment {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  // in P [m]
};

struct Joint {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();         // p_PJ [m]; on a designed parent, where the file has it
  Eigen::Vector3d orientation_rpy = Eigen::Vector3d::Zero();  // of J in P [rad]
  std::optional<Attachment> attachment;                       // none: Jo itself
  JointKind kind;

  const Eigen::Vector3d& GetAttachmentPoint() const { return attachment ? attachment->point : position; }
};

}  // namespace knap
