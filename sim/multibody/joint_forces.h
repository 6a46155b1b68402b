// What acts within a joint: damping, a spring to a rest position, limits, actuators. With x the joint's coordinates, v
// its rates and u an actuator's control, the generalised force is the sum of
//
//   damping     −d v
//   spring      −k (x − rest);  for a ball −k sin(angle) axis of the turn from Exp(rest), the gradient of
//               k (1 − cos angle): smooth at every rotation, −k × the rotation vector where that is small
//   limit       −K(x − upper) D(1 + c v) + K(lower − x) D(1 − c v),   K = stiffness × ramp of given width, D = ramp of
//               width 1: C², pushes back alone (D ≥ 0), and is undamped at its onset [Hunt & Crossley 1975]
//   force       effort_limit u
//   position    E tanh(e / E),  e = stiffness (u − x) − damping v,  E = effort_limit
//
// each with exact derivatives. They touch only the joint's own block of the linearised residual.
#pragma once

#include <Eigen/Dense>
#include <limits>

namespace knap {

// One-sided springs at the ends of a joint's range; revolute and prismatic joints only.
struct JointLimit {
  double lower = -std::numeric_limits<double>::infinity();  // [rad, m]
  double upper = std::numeric_limits<double>::infinity();
  double stiffness = 0.0;  // [N m/rad, N/m]
  double damping = 0.0;    // relative to the elastic force [s/rad, s/m]
  double width = 1e-3;     // over which the stiffness sets in [rad, m], > 0
};

// What a joint does by itself. For a revolute or prismatic joint the first entry of `rest` counts; a ball's rest
// orientation is Exp(rest).
struct JointLaw {
  double damping = 0.0;                            // [N m s/rad, N s/m]
  double stiffness = 0.0;                          // [N m/rad, N/m]
  Eigen::Vector3d rest = Eigen::Vector3d::Zero();  // [rad, m]
  JointLimit limit;
};

enum class ActuatorKind { kForce, kPosition };

// Acts on one degree of freedom of a body's joint. A force actuator's control lies in [−1, 1], kept there by who sets
// it; a position actuator's is the target [rad, m], and its joint is not a ball.
struct Actuator {
  int body = 0;
  int dof = 0;  // 0 … of the joint
  ActuatorKind kind = ActuatorKind::kForce;
  double effort_limit = 0.0;  // [N m, N], > 0
  double stiffness = 0.0;     // position: [N m/rad, N/m]
  double damping = 0.0;       // position: [N m s/rad, N s/m]
};

// A joint's generalised force, the magnitudes of its terms, and its derivatives in the joint's tangent and rates.
struct JointForce {
  Eigen::Vector3d tau = Eigen::Vector3d::Zero();
  Eigen::Vector3d magnitude = Eigen::Vector3d::Zero();
  Eigen::Matrix3d by_pose = Eigen::Matrix3d::Zero();
  Eigen::Vector3d by_v = Eigen::Vector3d::Zero();  // diagonal
};

// Adds a law's force. `q` and `v` point to the joint's coordinates (a ball's: quaternion x, y, z, w) and rates.
void AddDamping(const JointLaw& law, int dof, const double* v, JointForce* force);
void AddSpring(const JointLaw& law, int dof, const double* q, JointForce* force);  // dof 1, or 3 for a translation
void AddBallSpring(const JointLaw& law, const double* q, JointForce* force);
void AddLimit(const JointLimit& limit, double x, double v, JointForce* force);
// `x` and `v` of the actuated degree of freedom. Returns dtau/du.
double AddActuator(const Actuator& actuator, double x, double v, double u, JointForce* force);

// Cotangents of a law's numbers under the cotangent `bar` of the force (dof values); limits have none.
struct JointLawCotangent {
  double damping = 0.0;
  double stiffness = 0.0;
  Eigen::Vector3d rest = Eigen::Vector3d::Zero();
};
void PullBackLaw(const JointLaw& law, int dof, const double* q, const double* v, const double* bar,
                 JointLawCotangent* out);
void PullBackBallLaw(const JointLaw& law, const double* q, const double* v, const double* bar, JointLawCotangent* out);

}  // namespace knap
