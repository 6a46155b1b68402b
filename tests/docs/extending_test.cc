// The signal that docs/extending.md adds: its value and its pull-back against a difference.
#include "extending_example.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace knap {
namespace {

TEST(Extending, TheExampleIsExact) {
  const Eigen::VectorXd none;
  BodyKinematics kin;
  kin.X_WB.R = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  const Eigen::Vector3d v_W(0.3, -0.4, 1.2);
  const auto calc = [&](const Eigen::Vector3d& velocity_W, SignalCotangents* bar) {
    kin.V.setZero();
    kin.V.tail<3>() = kin.X_WB.R.transpose() * velocity_W;
    const std::vector<BodyKinematics> bodies{kin};
    const Moment at{0, 0.0, none, none, bodies};
    if (bar != nullptr) MakePaceSignal(0)->PullBack(at, 2.0, bar);
    return MakePaceSignal(0)->Calc(at);
  };
  SignalCotangents bar;
  EXPECT_NEAR(calc(v_W, &bar), 1.3, 1e-15);
  ASSERT_EQ(bar.states.size(), 1u);
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d h = 1e-6 * Eigen::Vector3d::Unit(i);
    EXPECT_NEAR(bar.states[0].v_W(i), 2.0 * (calc(v_W + h, nullptr) - calc(v_W - h, nullptr)) / 2e-6, 1e-9);
  }
  SignalCotangents at_rest;
  EXPECT_EQ(calc(Eigen::Vector3d::Zero(), &at_rest), 0.0);
  EXPECT_TRUE(at_rest.states.empty());
}

}  // namespace
}  // namespace knap
