// Controls to commands and back: order, shapes, and the derivative against differences.
#include "sim/rollout/control_commands.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

namespace knap {
namespace control_commands_test {

Controls MakeControls(Squash squash) {
  Controls controls;
  controls.actuators = {"knuckle", "first", "second"};
  controls.interval = 0.1;
  controls.squash = squash;
  return controls;
}

const Eigen::VectorXd kValues = (Eigen::VectorXd(6) << 0.0, 0.5, -0.5, 1.0, -2.0, 3.0).finished();

TEST(ControlCommandsTest, CountsOfTheReachingScene) {
  Scene scene;
  EXPECT_EQ(CountControls(scene), 0);
  scene.rollout.horizon = 3.0;
  scene.rollout.step = 5e-3;
  scene.controls = MakeControls(Squash::kTanh);
  scene.controls->actuators.push_back("third");
  EXPECT_EQ(CalcHoldSteps(scene.controls->interval, scene.rollout), 20);
  EXPECT_EQ(CountIntervals(scene.controls->interval, scene.rollout), 30);
  EXPECT_EQ(CountControls(scene), 120);
}

TEST(ControlCommandsTest, ActuatorsOfOneIntervalStandTogether) {
  const Eigen::MatrixXd u = CalcCommands(MakeControls(Squash::kNone), kValues);
  ASSERT_EQ(u.rows(), 3);
  ASSERT_EQ(u.cols(), 2);
  EXPECT_EQ(u(1, 0), 0.5);
  EXPECT_EQ(u(0, 1), 1.0);
  EXPECT_EQ(u(2, 1), 3.0);
  EXPECT_EQ(CalcCommands(MakeControls(Squash::kTanh), kValues)(1, 1), std::tanh(-2.0));
}

TEST(ControlCommandsTest, PullsBackWhatDifferencesSay) {
  Eigen::MatrixXd bar_u(3, 2);
  bar_u << 1.0, -2.0,  //
      0.3, 0.7,        //
      -1.1, 5.0;
  for (const Squash squash : {Squash::kTanh, Squash::kNone}) {
    const Controls controls = MakeControls(squash);
    const auto evaluate = [&](const Eigen::VectorXd& a) {
      return (bar_u.array() * CalcCommands(controls, a).array()).sum();
    };
    const Eigen::VectorXd bar_a = PullBackCommands(controls, kValues, bar_u);
    ASSERT_EQ(bar_a.size(), 6);
    constexpr double kStep = 1e-6;
    for (Eigen::Index k = 0; k < 6; ++k) {
      Eigen::VectorXd above = kValues, below = kValues;
      above(k) += kStep;
      below(k) -= kStep;
      // Rounding of values near 10 over 2e-6, and the third derivative times the step squared.
      EXPECT_NEAR(bar_a(k), (evaluate(above) - evaluate(below)) / (2.0 * kStep), 2e-9) << k;
      EXPECT_NE(bar_a(k), 0.0);
    }
  }
}

TEST(ControlCommandsTest, WrongSizesAreRefused) {
  const Controls controls = MakeControls(Squash::kTanh);
  EXPECT_THROW(CalcCommands(controls, kValues.head(5)), std::invalid_argument);
  EXPECT_THROW(PullBackCommands(controls, kValues, Eigen::MatrixXd::Zero(2, 3)), std::invalid_argument);
}

}  // namespace control_commands_test
}  // namespace knap
