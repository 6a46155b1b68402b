#include "tests/sim/dynamics/mechanisms.h"

#include <string>

namespace knap::test {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

// A solid box of the given sides about its centre of mass.
Matrix6d MakeBoxInertia(double mass, const Vector3d& side, const Vector3d& center) {
  const Vector3d s2 = side.cwiseAbs2();
  const Matrix3d I = mass / 12.0 * (s2.sum() * Vector3d::Ones() - s2).asDiagonal();
  return MakeSpatialInertia(mass, center, I);
}

}  // namespace

std::vector<BoxLink> AddFinger(Tree* tree, int parent, const Actuator& motor) {
  constexpr double kDensity = 1000.0;
  constexpr double kDamping = 1e5 * 1e-7;  // dyn cm s
  std::vector<BoxLink> links;
  // `at` is the joint in the frame of the link before.
  const auto add = [&](const std::string& name, JointType joint, const Vector3d& axis, double at, double x0, double x1,
                       double width, double height) {
    TreeBody body;
    body.name = name;
    body.parent = links.empty() ? parent : links.back().body;
    body.joint = joint;
    body.axis = axis;
    body.X_PF.p.x() = at;
    const Vector3d side(x1 - x0, width, height);
    body.M = MakeBoxInertia(kDensity * side.prod(), side, Vector3d(0.5 * (x0 + x1), 0.0, 0.0));
    if (joint != JointType::kFixed) body.law.damping = kDamping;
    links.push_back({tree->AddBody(body), x0, x1, width, height});
    if (joint == JointType::kFixed) return;
    Actuator actuator = motor;
    actuator.body = links.back().body;
    actuator.dof = 0;
    tree->AddActuator(actuator);
  };
  const Vector3d y = Vector3d::UnitY();
  add("palm", JointType::kFixed, y, 0.0, 0.0, 0.007, 0.016, 0.0324);
  add("knuckle", JointType::kRevolute, Vector3d::UnitZ(), 0.023, -0.016, 0.0115, 0.021, 0.029);
  double end = 0.0115;
  for (int i = 0; i < 3; ++i) {
    const std::string number = std::to_string(i);
    add("joint " + number, JointType::kRevolute, y, end + 0.0098, -0.0098, 0.0108, 0.026, 0.026);
    add("phalanx " + number, JointType::kFixed, y, 0.0108, 0.0, 0.0234, 0.026, 0.026);
    end = 0.0234;
  }
  add("tip", JointType::kFixed, y, end, 0.0, 0.0221, 0.026, 0.026);
  return links;
}

Tree MakeFinger() {
  Tree tree;
  tree.gravity.setZero();
  Actuator motor;
  motor.kind = ActuatorKind::kForce;
  motor.effort_limit = 6e5 * 1e-7;  // dyn cm
  AddFinger(&tree, -1, motor);
  return tree;
}

Tree MakeChain(int links, double damping) {
  Tree tree;
  constexpr double kMass = 0.0015;
  constexpr double kPitch = 0.03;
  for (int i = 0; i < links; ++i) {
    TreeBody body;
    body.name = "link " + std::to_string(i);
    body.parent = i - 1;
    body.joint = JointType::kBall;
    if (i > 0) body.X_PF.p.z() = -kPitch;
    body.law.damping = damping;
    body.M = MakeBoxInertia(kMass, Vector3d(0.008, 0.008, kPitch), Vector3d(0.0, 0.0, -0.5 * kPitch));
    tree.AddBody(body);
  }
  return tree;
}

}  // namespace knap::test
