// Steps of chosen length: errors answer to the tolerance, the same steps come out every time, and nothing is missed.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/sim/dynamics/scenes.h"

namespace knap {
namespace chosen_steps_test {

using Eigen::Vector3d;
using Eigen::VectorXd;
using test::BallScene;

BallScene MakeFall(double speed, double damping) {
  BallScene scene;
  scene.AddGround({});
  scene.AddBall();
  scene.Touch(scene.ground, {2e8, damping, 0.4, 0.03, 1e-3});
  scene.Start(Vector3d(0, 0, 0.03), Vector3d(0.2, 0.1, -speed), Vector3d(3, -5, 10));
  return scene;
}

Trajectory Throw(const BallScene& scene, double tolerance, double step, double duration) {
  Dynamics dynamics(scene.tree);
  ContactModel contacts(scene.contacts);
  SimulationOptions options = test::MakeOptions(step, duration, 2);
  options.tolerance = tolerance;
  options.newton_tolerance = 1e-13;
  Trajectory t = Simulator(&dynamics, &contacts).Run(scene.q0, scene.v0, options);
  EXPECT_TRUE(t.certificate.converged);
  return t;
}

TEST(ChosenSteps, ErrorsFallWithTheTolerance) {
  const BallScene scene = MakeFall(0.3, 1.0);
  const Trajectory exact = Throw(scene, 1e-7, 4e-3, 0.3);
  const VectorXd end = exact.q(exact.size() - 1);
  double previous = 0.0;
  int states = 0;
  for (const double tolerance : {1e-2, 1e-4, 1e-6}) {
    const Trajectory t = Throw(scene, tolerance, 4e-3, 0.3);
    const double error = (t.q(t.size() - 1) - end).norm();
    if (previous > 0.0) {
      EXPECT_LT(error, 0.25 * previous) << tolerance;
      EXPECT_GT(t.size(), states);
    }
    previous = error;
    states = t.size();
  }
}

TEST(ChosenSteps, AreTheSameEveryTimeAndWithinTheirGrid) {
  const BallScene scene = MakeFall(0.3, 1.0);
  const Trajectory a = Throw(scene, 1e-3, 4e-3, 0.3);
  const Trajectory b = Throw(scene, 1e-3, 4e-3, 0.3);
  ASSERT_EQ(a.size(), b.size());
  for (int k = 0; k < a.size(); ++k) {
    EXPECT_EQ(a.time(k), b.time(k));
    EXPECT_EQ(a.q(k), b.q(k));
  }
  for (int n = 0; n <= a.whole_steps(); ++n) EXPECT_EQ(a.time(a.state_of_step(n)), n * 4e-3);
  EXPECT_EQ(a.whole_steps(), 75);
  EXPECT_GT(a.certificate.rejected_steps, 0);  // at the impact
}

// Without the bound on the closing speed the ball is behind the face within one step, where nothing stops it.
TEST(ChosenSteps, MissNoContactAtAnySpeed) {
  for (const double speed : {0.5, 2.0, 4.0, 8.0}) {
    for (int i = 0; i < 10; ++i) {
      BallScene scene = MakeFall(speed, 0.0);
      scene.q0(2) += 0.0037 * i;
      const Trajectory t = Throw(scene, 1e-2, 4e-3, 0.1);
      double lowest = 1.0;
      for (int k = 0; k < t.size(); ++k) lowest = std::min(lowest, t.q(k)(2));
      EXPECT_GT(lowest, 0.0) << speed;
      EXPECT_EQ(t.certificate.contact_onsets, 1) << speed;
      EXPECT_GT(t.v(t.size() - 1)(2), 0.8 * speed - 1.0);
      // No more than it had, with what it fell from.
      const double fall = 2.0 * 9.81 * (scene.q0(2) - scene.radius);
      EXPECT_LT(t.v(t.size() - 1)(2), 1.01 * std::sqrt(speed * speed + fall)) << speed;
    }
  }
}

// Forces that jump with the controls, and the acceleration with them: order 2 is kept.
TEST(ChosenSteps, KeepTheirOrderWhereControlsJump) {
  Tree tree;
  TreeBody slide;
  slide.joint = JointType::kPrismatic;
  slide.law.stiffness = 300.0;
  slide.law.damping = 2.0;
  slide.M = MakeSpatialInertia(1.0, Vector3d::Zero(), 0.01 * Eigen::Matrix3d::Identity());
  tree.AddBody(slide);
  tree.gravity.setZero();
  tree.AddActuator({0, 0, ActuatorKind::kForce, 10.0, 0.0, 0.0});
  ContactModel none({});
  Dynamics dynamics(tree);
  const auto run = [&](int per_interval) {
    ControlSequence controls;
    controls.steps_per_interval = per_interval;
    controls.values.resize(1, 5);
    controls.values << 0.9, -0.8, 0.5, -0.9, 0.7;
    SimulationOptions options = test::MakeOptions(0.1 / per_interval, 0.5, 2);
    options.tolerance = 1e9;  // every step is accepted, as long as it may be
    const Trajectory t = Simulator(&dynamics, &none).Run(VectorXd::Zero(1), VectorXd::Zero(1), options, controls);
    EXPECT_EQ(t.certificate.rejected_steps, 0);
    return Eigen::Vector2d(t.q(t.size() - 1)(0), 0.1 * t.v(t.size() - 1)(0));
  };
  const Eigen::Vector2d exact = run(800);
  const double coarse = (run(10) - exact).norm();
  const double fine = (run(20) - exact).norm();
  EXPECT_NEAR(std::log2(coarse / fine), 2.0, 0.15);
}

}  // namespace chosen_steps_test
}  // namespace knap
