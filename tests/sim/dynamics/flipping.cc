#include "tests/sim/dynamics/flipping.h"

#include <algorithm>

namespace knap::test {

using Eigen::Vector3d;

namespace {

constexpr double kSide = 0.06;      // of the box [m]
constexpr double kReach = 0.1886;   // of the finger [m]
constexpr double kHeight = 0.045;   // of the finger above the floor [m]
constexpr double kGap = 0.002;      // between fingertip and box at the start [m]
constexpr double kAdvance = 0.055;  // of the base [m]
constexpr double kRise = 0.035;     // of the base [m]
constexpr int kStepsPerInterval = 5;
constexpr int kIntervals = 60;

BoxGeometry MakeShape(const BoxLink& link) {
  return {0.5 * Vector3d(link.x1 - link.x0, link.width, link.height), Vector3d(0.5 * (link.x0 + link.x1), 0.0, 0.0)};
}

}  // namespace

Flipping MakeFlipping() {
  Flipping out;
  Tree& tree = out.tree;
  const int floor = tree.AddBody({});

  // The base: its slides weigh nothing, the finger on it does.
  int base = -1;
  for (const Vector3d& axis : {Vector3d(Vector3d::UnitX()), Vector3d(Vector3d::UnitZ())}) {
    TreeBody slide;
    slide.parent = base;
    slide.joint = JointType::kPrismatic;
    slide.axis = axis;
    slide.law.damping = 10.0;
    if (base < 0) slide.X_PF.p.z() = kHeight;
    base = tree.AddBody(slide);
    tree.AddActuator({base, 0, ActuatorKind::kPosition, 20.0, 2000.0, 40.0});
  }
  Actuator motor;
  motor.kind = ActuatorKind::kPosition;
  motor.effort_limit = 1.0;
  motor.stiffness = 20.0;
  motor.damping = 0.1;
  const std::vector<BoxLink> links = AddFinger(&tree, base, motor);

  TreeBody box;
  box.joint = JointType::kRevolute;
  box.axis = Vector3d::UnitY();
  box.X_PF.p.x() = kReach + kGap + kSide;
  box.law.damping = 1e-3;
  const double mass = 1000.0 * kSide * kSide * kSide;
  const Vector3d center(-0.5 * kSide, 0.0, 0.5 * kSide);
  box.M = MakeSpatialInertia(mass, center, mass * kSide * kSide / 6.0 * Eigen::Matrix3d::Identity());
  out.box = tree.AddBody(box);
  out.hinge = tree.bodies()[out.box].q_start;

  const BoxGeometry box_shape{Vector3d::Constant(0.5 * kSide), center};
  const ContactMaterial material{2e7, 1.0, 0.8, 0.0, 1e-3, 2e-5};
  const auto touch = [&](int a, const ContactGeometry& shape_a, int b, const ContactGeometry& shape_b) {
    ContactPair pair;
    pair.bodies = {a, b};
    pair.shapes = {shape_a, shape_b};
    pair.material = material;
    out.contacts.push_back(pair);
  };
  touch(out.box, box_shape, floor, HalfSpaceGeometry{});
  for (const std::size_t link : {links.size() - 1, links.size() - 2}) {
    touch(links[link].body, MakeShape(links[link]), floor, HalfSpaceGeometry{});
    out.finger_on_box = link == links.size() - 1 ? static_cast<int>(out.contacts.size()) : out.finger_on_box;
    touch(links[link].body, MakeShape(links[link]), out.box, box_shape);
  }

  out.q0 = tree.MakeDefaultPositions();
  out.v0.setZero(tree.nv());
  out.controls.steps_per_interval = kStepsPerInterval;
  out.controls.values.setZero(tree.num_controls(), kIntervals);
  for (int i = 0; i < kIntervals; ++i) {
    const double share = std::min(1.0, (i + 1) / 40.0);
    out.controls.values(0, i) = kAdvance * share;
    out.controls.values(1, i) = kRise * share;
  }
  out.options.step = 5e-3;
  out.options.steps = kStepsPerInterval * kIntervals;
  out.options.newton_tolerance = 1e-10;
  return out;
}

}  // namespace knap::test
