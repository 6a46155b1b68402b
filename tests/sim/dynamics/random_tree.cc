#include "tests/sim/dynamics/random_tree.h"

#include <cmath>

#include "sim/math/so3.h"

namespace knap::test {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

RandomTree::RandomTree(std::uint64_t seed) : generator_(seed) {
  const int count = 3 + Pick(5);
  for (int i = 0; i < count; ++i) tree.AddBody(MakeBody(i));
  tree.gravity = 9.0 * Vec();
  for (int i = 0; i < count; ++i) {
    const TreeBody& body = tree.bodies()[i];
    const int n = CountDof(body.joint);
    if (n == 0 || Pick(3) == 0) continue;
    Actuator actuator{i, Pick(n), ActuatorKind::kForce, 2.0 + U(), 3.0 + U(), 0.5 + 0.4 * U()};
    if (body.joint != JointType::kBall && Pick(2) == 0) actuator.kind = ActuatorKind::kPosition;
    tree.AddActuator(actuator);
  }
  controls = Values(tree.num_controls(), 0.9);
  const VectorXd start = tree.MakeDefaultPositions();
  q = start;
  tree.AddIncrement(start, Values(tree.nv(), 1.0), &q);
  xi_prev = Values(tree.nv(), 0.3);
  xi = Values(tree.nv(), 0.5);
  external_slope.resize(tree.size());
  for (Matrix6d& m : external_slope) m = Matrix6d::NullaryExpr([this] { return U(); });
}

TreeBody RandomTree::MakeBody(int i) {
  TreeBody body;
  body.parent = i == 0 ? -1 : Pick(i + 1) - 1;
  const JointType kinds[] = {JointType::kRevolute, JointType::kPrismatic,  JointType::kTranslation,
                             JointType::kBall,     JointType::kPrescribed, JointType::kFixed};
  body.joint = i == 0 ? JointType::kBall : kinds[Pick(6)];
  body.X_PF = {ExpSo3(Vec()).toRotationMatrix(), Vec()};
  body.axis = Vec().normalized();
  body.law.damping = 0.3 * (1.0 + U());
  if (Pick(2) == 0) {
    body.law.stiffness = 2.0 + U();
    body.law.rest = 0.8 * Vec();
  }
  if (CountDof(body.joint) == 1 && Pick(2) == 0) {
    // Coordinates lie in [−1.5, 1.5]: many start beyond an end, on the ramp or above it.
    body.law.limit = {-0.3 + 0.2 * U(), 0.3 + 0.2 * U(), 5.0, 0.3, 0.4};
  }
  body.motion = [](double t) {
    PrescribedState s;
    s.X_FB.p = Vector3d(std::sin(t), t * t, 0.0);
    s.V.tail<3>() = Vector3d(std::cos(t), 2.0 * t, 0.0);
    s.A.tail<3>() = Vector3d(-std::sin(t), 2.0, 0.0);
    s.jerk.tail<3>() = Vector3d(-std::cos(t), 0.0, 0.0);
    return s;
  };
  const Matrix3d a = Matrix3d::NullaryExpr([this] { return U(); });
  body.M = MakeSpatialInertia(1.0 + 0.5 * U(), 0.3 * Vec(), a * a.transpose() + Matrix3d::Identity());
  return body;
}

void RandomTree::Couple(int count) {
  for (int i = 0; i < count; ++i) {
    Coupling c;
    c.body = Pick(tree.size());
    c.other = Pick(tree.size());
    c.by_position = Eigen::Matrix<double, 6, 3>::NullaryExpr([this] { return 30.0 * U(); });
    c.by_turn = Eigen::Matrix<double, 6, 3>::NullaryExpr([this] { return 30.0 * U(); });
    c.by_twist = Matrix6d::NullaryExpr([this] { return 3.0 * U(); });
    c.marker = Vec();
    couplings.push_back(c);
  }
}

Tree RandomTree::Rebuild(const std::vector<TreeBody>& bodies, const std::vector<Actuator>& actuators,
                         const Vector3d& gravity) {
  Tree out;
  for (const TreeBody& body : bodies) out.AddBody(body);
  for (const Actuator& actuator : actuators) out.AddActuator(actuator);
  out.gravity = gravity;
  return out;
}

}  // namespace knap::test
