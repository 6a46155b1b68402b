// Starting from exact rest: no joint moves or feels a torque at the first evaluation, and still the step must be
// solved.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/sim/dynamics/scenes.h"

namespace knap {
namespace rest_start_test {

using Eigen::Vector3d;
using test::BallScene;

class SlopeTest : public testing::TestWithParam<double> {};

TEST_P(SlopeTest, ABallReleasedFromRestStartsToRoll) {
  const ContactMaterial material{1.3e8, 2.0, 0.4, 0.0, 1e-3};  // configs/pushing.yaml's
  BallScene scene;
  Pose tilt;
  tilt.R = Eigen::AngleAxisd(GetParam(), Vector3d::UnitY()).toRotationMatrix();
  scene.AddGround(tilt);
  scene.AddBall();
  scene.Touch(scene.ground, material);
  const double height = test::FindRestingHeight(scene, material, 9.81 * std::cos(GetParam()));
  scene.Start(height * tilt.R.col(2), Vector3d::Zero(), Vector3d::Zero());
  SimulationOptions options = test::MakeOptions(2e-3, 0.1, 2);
  options.newton_tolerance = 1e-8;
  Dynamics dynamics(scene.tree);
  ContactModel contacts(scene.contacts);
  const Trajectory trajectory = Simulator(&dynamics, &contacts).Run(scene.q0, scene.v0, options);
  ASSERT_TRUE(trajectory.certificate.converged) << "failed in step " << trajectory.whole_steps();
  const double speed = 5.0 / 7.0 * 9.81 * std::sin(GetParam()) * 0.1;
  EXPECT_NEAR(tilt.R.col(0).dot(trajectory.v(trajectory.size() - 1).head<3>()), speed, 0.01 * speed);
}

INSTANTIATE_TEST_SUITE_P(Slopes, SlopeTest, testing::Values(0.01, 0.1, 0.5));

}  // namespace rest_start_test
}  // namespace knap
