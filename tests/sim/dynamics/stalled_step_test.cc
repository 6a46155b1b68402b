// A step whose residual has a least value that is not zero, where a line search is held up: the step must be taken
// whole all the same, to the root that is there.
//
// A flywheel turns about a ball joint whose spring is −k sin(angle), stiffer than the inertia over a step: starting at
// rest at x0 = 2.3, implicit Euler's equation is
//
//   I (x − x0)/h² + k sin x = 0,    with I/h² = k/2:   (x − x0)/2 + sin x = 0
//
// which has one root, at 0.8, and at 4π/3 a minimum of 0.08 that Newton's method falls into from x0.
//
// And the other way round: a root that is too far away to be this step's.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "sim/integrators/simulate.h"

namespace knap {
namespace stalled_step_test {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kStart = 2.3;  // [rad]

struct Flywheel {
  Tree tree;
  VectorXd q0;
  VectorXd v0;
  explicit Flywheel(double stiffness) {
    TreeBody body;
    body.name = "flywheel";
    body.joint = JointType::kBall;
    body.law.stiffness = stiffness;
    body.M = MakeSpatialInertia(1.0, Vector3d::Zero(), Matrix3d::Identity());
    tree.AddBody(body);
    q0 = tree.MakeDefaultPositions();
    q0 << 0.0, 0.0, std::sin(0.5 * kStart), std::cos(0.5 * kStart);
    v0 = VectorXd::Zero(tree.nv());
  }
};

double CalcRoot() {
  double low = 0.0, high = 1.0;
  for (int i = 0; i < 60; ++i) {
    const double x = 0.5 * (low + high);
    (0.5 * (x - kStart) + std::sin(x) < 0.0 ? low : high) = x;
  }
  return low;
}

TEST(StalledStep, GoesOnToTheRootInsteadOfBeingCut) {
  SimulationOptions options;
  options.step = 0.1;
  options.steps = 1;
  options.order = 1;
  options.newton_tolerance = 1e-13;
  const Flywheel flywheel(2.0 / (options.step * options.step));
  Dynamics dynamics(flywheel.tree);
  ContactModel contacts({});
  const Trajectory trajectory = Simulator(&dynamics, &contacts).Run(flywheel.q0, flywheel.v0, options);
  ASSERT_TRUE(trajectory.certificate.converged);
  EXPECT_EQ(trajectory.certificate.subdivided_steps, 0);
  const auto q = trajectory.q(1);
  EXPECT_NEAR(2.0 * std::atan2(q(2), q(3)), CalcRoot(), 1e-12);
}

// A free wheel, at a given turn a step: its equation has its root there, however far that is.
Trajectory SpinWheel(JointType joint, double turn) {
  TreeBody body;
  body.name = "wheel";
  body.joint = joint;
  body.M = MakeSpatialInertia(1.0, Vector3d::Zero(), Matrix3d::Identity());
  Tree tree;
  tree.AddBody(body);
  SimulationOptions options;
  options.step = 0.1;
  options.steps = 1;
  Dynamics dynamics(tree);
  ContactModel contacts({});
  VectorXd v0 = VectorXd::Zero(tree.nv());
  v0(0) = turn / options.step;
  return Simulator(&dynamics, &contacts).Run(tree.MakeDefaultPositions(), v0, options);
}

TEST(StalledStep, ARootBeyondHalfATurnIsNone) {
  for (const JointType joint : {JointType::kRevolute, JointType::kBall}) {
    EXPECT_EQ(SpinWheel(joint, 3.1).certificate.subdivided_steps, 0);
    const Trajectory cut = SpinWheel(joint, 3.2);
    EXPECT_TRUE(cut.certificate.converged);
    EXPECT_EQ(cut.size(), 3);  // the start and two halves
    EXPECT_FALSE(SpinWheel(joint, 1.1 * std::numbers::pi * (1 << kMaxSubdivisions)).certificate.converged);
  }
}

}  // namespace stalled_step_test
}  // namespace knap
