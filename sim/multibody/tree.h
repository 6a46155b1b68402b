// A forest of rigid bodies: topology, joints, inertia. Constant during a rollout; the state lives elsewhere.
//
// Each body has one joint to its parent (an earlier body, or the world). Its frame B is the joint's moving frame:
// X_PB = X_PF · X_FB(q). Joints move on a subgroup, so that a constant 6×n matrix S (in B) maps rates to twists,
// V_FB = S v, and increments compose on the right, q ⊕ xi = X_FB(q) · Exp(S xi):
//
//   fixed        n 0
//   prescribed   n 0     X_FB, twist and its rate are functions of time
//   revolute     n 1     S = [axis; 0]
//   prismatic    n 1     S = [0; axis]
//   translation  n 3     S = [0; I], q in F
//   ball         n 3     S = [I; 0], q a unit quaternion
//
// A free joint is a translation followed by a ball, a planar joint two prismatic ones followed by a revolute: linear
// momentum then is integrated in a fixed frame, where a force-free body keeps it exactly, and no rotation is singular.
#pragma once

#include <Eigen/Dense>
#include <functional>
#include <string>
#include <vector>

#include "sim/math/pose.h"
#include "sim/multibody/joint_forces.h"

namespace knap {

enum class JointType { kFixed, kPrescribed, kRevolute, kPrismatic, kTranslation, kBall };

// The motion of a prescribed joint at one time, in its moving frame.
struct PrescribedState {
  Pose X_FB;
  Vector6d V = Vector6d::Zero();     // twist of B in F, expressed in B
  Vector6d A = Vector6d::Zero();     // time derivative of V's components
  Vector6d jerk = Vector6d::Zero();  // and of A's
};
using PrescribedMotion = std::function<PrescribedState(double time)>;

// Spatial inertia about Bo in B: [I, m [c]×; −m [c]×, m 1] for a centre of mass c = p_BoBcm_B, with the rotational
// inertia I = I_BBcm_B − m [c]×[c]× about Bo.
Matrix6d MakeSpatialInertia(double mass, const Eigen::Vector3d& p_BoBcm_B, const Eigen::Matrix3d& I_BBcm_B);

struct TreeBody {
  std::string name;
  int parent = -1;  // index of an earlier body, −1 the world
  JointType joint = JointType::kFixed;
  Pose X_PF;
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  // unit; revolute and prismatic
  JointLaw law;
  PrescribedMotion motion;
  Matrix6d M = Matrix6d::Zero();
  int q_start = 0;  // set by Tree
  int v_start = 0;
};

class Tree {
 public:
  // Returns the body's index. The parent must exist.
  int AddBody(TreeBody body);

  const std::vector<TreeBody>& bodies() const { return bodies_; }
  int size() const { return static_cast<int>(bodies_.size()); }
  int nq() const { return nq_; }
  int nv() const { return nv_; }
  Eigen::Vector3d gravity = Eigen::Vector3d(0.0, 0.0, -9.81);  // in the world [m/s²]

  // Returns the actuator's index, that of its control. The body must exist and have the degree of freedom.
  int AddActuator(const Actuator& actuator);
  const std::vector<Actuator>& actuators() const { return actuators_; }
  int num_controls() const { return static_cast<int>(actuators_.size()); }

  // All joints at zero, balls at the identity.
  Eigen::VectorXd MakeDefaultPositions() const;

  // q ⊕ xi, per joint; tangent increments in the order of v. `result` may be &q.
  void AddIncrement(const Eigen::VectorXd& q, const Eigen::VectorXd& xi, Eigen::VectorXd* result) const;

  // Whether the body's pose depends on any joint coordinate (fixed and prescribed chains do not).
  bool IsDynamic(int body) const;

 private:
  std::vector<TreeBody> bodies_;
  std::vector<Actuator> actuators_;
  int nq_ = 0;
  int nv_ = 0;
};

// Number of degrees of freedom of a joint.
int CountDof(JointType joint);

}  // namespace knap
