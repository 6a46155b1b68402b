#include "sim/multibody/tree.h"

#include <cmath>
#include <utility>

#include "sim/math/check.h"
#include "sim/math/so3.h"

namespace knap {

Matrix6d MakeSpatialInertia(double mass, const Eigen::Vector3d& p_BoBcm_B, const Eigen::Matrix3d& I_BBcm_B) {
  const Eigen::Matrix3d c = Skew(p_BoBcm_B);
  Matrix6d M;
  M.topLeftCorner<3, 3>() = I_BBcm_B + mass * c * c.transpose();
  M.topRightCorner<3, 3>() = mass * c;
  M.bottomLeftCorner<3, 3>() = -mass * c;
  M.bottomRightCorner<3, 3>() = mass * Eigen::Matrix3d::Identity();
  return M;
}

int CountDof(JointType joint) {
  switch (joint) {
    case JointType::kFixed:
    case JointType::kPrescribed:
      return 0;
    case JointType::kRevolute:
    case JointType::kPrismatic:
      return 1;
    case JointType::kTranslation:
    case JointType::kBall:
      return 3;
  }
  KNAP_CHECK(false, "unknown joint kind {}", static_cast<int>(joint));
  return 0;
}

int Tree::AddBody(TreeBody body) {
  KNAP_CHECK(body.parent >= -1 && body.parent < size(), "body {} has parent {} of {}", body.name, body.parent, size());
  KNAP_CHECK(body.joint != JointType::kPrescribed || body.motion, "body {} has no motion", body.name);
  const bool limited = std::isfinite(body.law.limit.lower) || std::isfinite(body.law.limit.upper);
  KNAP_CHECK(!limited || CountDof(body.joint) == 1, "body {}: a limit on a joint that is not of one axis", body.name);
  KNAP_CHECK(body.law.limit.width > 0.0, "body {}: limit width {}", body.name, body.law.limit.width);
  body.q_start = nq_;
  body.v_start = nv_;
  nq_ += body.joint == JointType::kBall ? 4 : CountDof(body.joint);
  nv_ += CountDof(body.joint);
  bodies_.push_back(std::move(body));
  return size() - 1;
}

int Tree::AddActuator(const Actuator& actuator) {
  KNAP_CHECK(actuator.body >= 0 && actuator.body < size(), "actuator on body {} of {}", actuator.body, size());
  const TreeBody& body = bodies_[actuator.body];
  KNAP_CHECK(actuator.dof >= 0 && actuator.dof < CountDof(body.joint), "actuator on degree of freedom {} of body {}",
             actuator.dof, body.name);
  KNAP_CHECK(actuator.kind == ActuatorKind::kForce || body.joint != JointType::kBall,
             "position actuator on the ball joint of body {}", body.name);
  KNAP_CHECK(actuator.effort_limit > 0.0, "actuator of body {}: effort limit {}", body.name, actuator.effort_limit);
  actuators_.push_back(actuator);
  return num_controls() - 1;
}

Eigen::VectorXd Tree::MakeDefaultPositions() const {
  Eigen::VectorXd q = Eigen::VectorXd::Zero(nq_);
  for (const TreeBody& body : bodies_) {
    if (body.joint == JointType::kBall) q(body.q_start + 3) = 1.0;  // Eigen stores x, y, z, w
  }
  return q;
}

void Tree::AddIncrement(const Eigen::VectorXd& q, const Eigen::VectorXd& xi, Eigen::VectorXd* result) const {
  for (const TreeBody& body : bodies_) {
    if (body.joint == JointType::kBall) {
      const Eigen::Quaterniond old(q.segment<4>(body.q_start));
      Eigen::Quaterniond next = old * ExpSo3(xi.segment<3>(body.v_start));
      next.normalize();
      result->segment<4>(body.q_start) = next.coeffs();
    } else {
      for (int k = 0; k < CountDof(body.joint); ++k) {
        (*result)(body.q_start + k) = q(body.q_start + k) + xi(body.v_start + k);
      }
    }
  }
}

bool Tree::IsDynamic(int body) const {
  for (int i = body; i >= 0; i = bodies_[i].parent) {
    if (CountDof(bodies_[i].joint) > 0) return true;
  }
  return false;
}

}  // namespace knap
