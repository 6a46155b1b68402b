// The derivative of an impact's outcome against that of the problem: what bounces off a wall that stands elsewhere ends
// elsewhere by (1 + e) of that, e the restitution, whatever the phase of the touchdown within its step.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "sim/gradient/adjoint.h"
#include "tests/sim/dynamics/scenes.h"

namespace knap {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;
using test::BallScene;

constexpr double kRadius = 7e-3;

SimulationOptions ChosenSteps(double duration) {
  SimulationOptions options = test::MakeOptions(4e-3, duration, 2);
  options.tolerance = 1e-3;
  options.newton_tolerance = 1e-13;
  return options;
}

// A ball thrown at a wall that faces +y, which it meets after `flight` seconds.
struct Bounce {
  double restitution = 0.0;
  double by_wall = 0.0;   // dy(end)/d(the wall's place)
  double by_start = 0.0;  // dy(end)/dy(start): −e
  double by_speed = 0.0;  // dy(end)/dv(start): −(t_touch + e (T − t_touch)) + what is left of …, see the test
  int touchdowns = 0;
};

Bounce BounceOff(double speed, double flight, double damping, TimeNodes nodes) {
  BallScene scene;
  scene.tree.gravity.setZero();
  scene.radius = kRadius;
  scene.mass = 1.44e-3;
  scene.AddTool([](double) { return PrescribedState{}; });
  scene.AddBall();
  scene.Touch(scene.tool, {3e7, damping, 0.4, 0.0, 1e-3},
              std::make_shared<ContactMesh>(test::MakeBar(0.03, 0.012, 0.03, 1, 1)));
  scene.Start(Vector3d(0.001, kRadius + speed * flight, 0.012), Vector3d(0.0, -speed, 0.0), Vector3d::Zero());
  Dynamics dynamics(scene.tree);
  ContactModel contacts(scene.contacts);
  const Trajectory t = Simulator(&dynamics, &contacts).Run(scene.q0, scene.v0, ChosenSteps(0.4));
  EXPECT_TRUE(t.certificate.converged);
  const int last = t.size() - 1;
  Bounce out;
  out.restitution = t.v(last)(1) / speed;
  const TrajectoryGradient g = SweepAdjoint(t, {{last, scene.ball, Vector3d::UnitY(), Vector3d::Zero()}}, &dynamics,
                                            &contacts, nullptr, nodes);
  EXPECT_TRUE(g.finite && g.solvable);
  out.by_wall = g.vertices[0].row(1).sum();
  out.by_start = g.pose0(1);
  out.by_speed = g.v0(1);
  out.touchdowns = g.touchdowns;
  return out;
}

class TouchdownTest : public testing::TestWithParam<double> {};

TEST_P(TouchdownTest, FollowingNodesGiveTheProblemsDerivative) {
  const double speed = GetParam();
  double worst = 0.0;
  double worst_frozen = 0.0;
  for (const double damping : {0.0, 0.2 / speed}) {
    for (int i = 0; i < 20; ++i) {
      const double flight = 0.1 + 0.00021 * i;
      const Bounce bounce = BounceOff(speed, flight, damping, TimeNodes::kFollowing);
      EXPECT_EQ(bounce.touchdowns, 1);
      EXPECT_GT(bounce.restitution, 0.3);
      const double exact = 1.0 + bounce.restitution;
      worst = std::max(worst, std::abs(bounce.by_wall / exact - 1.0));
      // All displaced: the end too.
      EXPECT_NEAR(bounce.by_wall + bounce.by_start, 1.0, 1e-6);
      const Bounce frozen = BounceOff(speed, flight, damping, TimeNodes::kFrozen);
      worst_frozen = std::max(worst_frozen, std::abs(frozen.by_wall / exact - 1.0));
    }
  }
  RecordProperty("worst following", std::to_string(worst));
  RecordProperty("worst frozen", std::to_string(worst_frozen));
  std::printf("speed %g: following %g frozen %g\n", speed, worst, worst_frozen);
  EXPECT_LT(worst, 0.02);
  EXPECT_GT(worst_frozen, worst);
}

INSTANTIATE_TEST_SUITE_P(Speeds, TouchdownTest, testing::Values(0.06, 0.5, 2.0));

// Two equal balls, head on, undamped: they swap velocities, so x2 at the end hangs on the first one's start alone.
TEST(Touchdown, EqualBallsSwapTheirDerivatives) {
  constexpr double kT = 0.5;
  for (int i = 0; i < 20; ++i) {
    Tree tree;
    tree.gravity.setZero();
    for (int b = 0; b < 2; ++b) {
      TreeBody body;
      body.joint = JointType::kTranslation;
      body.M = MakeSpatialInertia(1.0, Vector3d::Zero(), 0.4 * 0.01 * Eigen::Matrix3d::Identity());
      tree.AddBody(body);
    }
    ContactPair pair;
    pair.bodies = {0, 1};
    pair.shapes = {SphereGeometry{0.1}, SphereGeometry{0.1}};
    pair.material.stiffness = 1e9;
    Dynamics dynamics(tree);
    ContactModel contacts({pair});
    VectorXd q0 = VectorXd::Zero(6);
    q0(3) = 0.2 + 0.1 + 0.0007 * i;
    VectorXd v0 = VectorXd::Zero(6);
    v0(0) = 1.0;
    SimulationOptions options = ChosenSteps(kT);
    options.step = 1e-3;
    options.steps = 500;
    const Trajectory t = Simulator(&dynamics, &contacts).Run(q0, v0, options);
    ASSERT_TRUE(t.certificate.converged);
    const int last = t.size() - 1;
    EXPECT_NEAR(t.v(last)(3), 1.0, 1e-3);
    const TrajectoryGradient g =
        SweepAdjoint(t, {{last, 1, Vector3d::UnitX(), Vector3d::Zero()}}, &dynamics, &contacts);
    std::printf("%g %g %g %g\n", g.pose0(0), g.pose0(3), g.v0(0), g.v0(3));
    EXPECT_NEAR(g.pose0(0), 1.0, 0.02);
    EXPECT_NEAR(g.pose0(3), 0.0, 0.02);
    EXPECT_NEAR(g.v0(0), kT, 0.02 * kT);
    EXPECT_NEAR(g.v0(3), 0.0, 0.02 * kT);
  }
}

}  // namespace
}  // namespace knap
