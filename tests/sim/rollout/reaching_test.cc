// configs/reaching.yaml: what DiffHand computes for the scene where nothing moves, and gradients in design and
// controls.
#include <gtest/gtest.h>

#include <cmath>

#include "sim/rollout/check_model.h"
#include "sim/rollout/rollout.h"
#include "sim/scenarios/scenario_files.h"
#include "tests/sim/rollout/differences.h"

namespace knap {
namespace reaching_test {

using Eigen::VectorXd;

class ReachingTest : public testing::Test {
 protected:
  ReachingTest() : scenario_(LoadScenario(KNAP_CONFIGS "/reaching.yaml")), model_(Check(scenario_)) {}

  static const std::map<std::string, std::string>& Check(LoadedScenario& scenario) {
    CheckModel(scenario);
    EXPECT_TRUE(scenario.parsed.ok()) << scenario.parsed.FormatErrors();
    return scenario.files;
  }

  // An action that moves every joint.
  VectorXd MakeAction() const {
    VectorXd a(model_.num_controls());
    for (Eigen::Index i = 0; i < a.size(); ++i) a(i) = 0.4 * std::sin(0.9 * static_cast<double>(i));
    return a;
  }

  RolloutOutput Run(const VectorXd& theta, const VectorXd& controls, bool gradient) {
    RolloutInput input;
    input.theta = theta;
    input.controls = controls;
    input.want_gradient = gradient;
    return model_.Run(input, {});
  }

  LoadedScenario scenario_;
  RolloutModel model_;
};

TEST_F(ReachingTest, InitialDesignWithoutActionCostsWhatDiffHandSays) {
  ASSERT_EQ(model_.num_parameters(), 9);
  ASSERT_EQ(model_.num_controls(), 120);
  const RolloutOutput out = Run(model_.initial_theta(), VectorXd::Zero(120), true);
  EXPECT_TRUE(out.certificate.converged);
  EXPECT_EQ(out.steps, 600);
  EXPECT_NEAR(out.loss, 3733.08325791, 1e-6);
  EXPECT_TRUE(out.gradient_reliable);
  ASSERT_EQ(out.gradient.size(), 9);
  ASSERT_EQ(out.control_gradient.size(), 120);
  // Masses matter to nothing that rests; lengths and the tip's height move the point.
  for (const int width : {0, 1, 2, 4}) EXPECT_EQ(out.gradient(width), 0.0) << width;
  for (const int other : {3, 5, 6, 7, 8}) EXPECT_NE(out.gradient(other), 0.0) << other;
  EXPECT_GT(out.control_gradient.lpNorm<Eigen::Infinity>(), 0.0);
}

// The tip's point by hand: (L/2, 0, h/2) of the tip, between the heights of both of its ends.
TEST_F(ReachingTest, LengthsAndHeightsPlaceTheTip) {
  VectorXd theta = model_.initial_theta();
  theta << 1.5, 0.7, 2.0, 1.4, 0.6, 0.8, 1.25, 0.5, 2.0;
  const Eigen::Vector3d p(17.755 + 2.34 * (0.25 - 0.5 + 1.0), 0.0, 1.3 * 0.5 * (1.4 + 0.8));
  const Eigen::Vector3d targets[] = {{10, -5, -5}, {10, -5, 5}, {20, 10, 10}, {20, 10, -10}};
  const int counts[] = {8, 7, 8, 7};
  double loss = 0.0;
  for (int k = 0; k < 4; ++k) loss += 10.0 * counts[k] * (p - targets[k]).norm();
  EXPECT_NEAR(Run(theta, VectorXd::Zero(120), false).loss, loss, 1e-9 * loss);
}

TEST_F(ReachingTest, GradientInDesignAndControlsIsThatOfDifferences) {
  VectorXd theta(9);
  theta << 1.2, 0.9, 0.8, 1.1, 0.6, 0.7, 1.3, 0.8, 1.5;
  const VectorXd a = MakeAction();
  const RolloutOutput out = Run(theta, a, true);
  ASSERT_TRUE(out.certificate.converged);
  EXPECT_TRUE(out.gradient_reliable);
  VectorXd x(129), g(129);
  x << theta, a;
  g << out.gradient, out.control_gradient;
  const auto evaluate = [&](const VectorXd& at) { return Run(at.head(9), at.tail(120), false).loss; };
  double worst = 0.0;
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    EXPECT_NE(g(i), 0.0) << i;
    if (i >= 9 && i % 7 != 0) continue;  // every seventh control
    worst = std::max(worst, std::abs(test::CalcDifference(evaluate, x, i, 1e-3) - g(i)));
  }
  EXPECT_LE(worst, 1e-7 * g.lpNorm<Eigen::Infinity>());
}

}  // namespace reaching_test
}  // namespace knap
