// configs/reaching_policy.yaml: gradients in design and weights, and what the policy is told.
#include <gtest/gtest.h>

#include <cmath>

#include "sim/rollout/check_model.h"
#include "sim/rollout/rollout.h"
#include "sim/scenarios/scenario_files.h"
#include "tests/sim/rollout/differences.h"

namespace knap {
namespace reaching_policy_test {

using Eigen::VectorXd;

class ReachingPolicyTest : public testing::Test {
 protected:
  // Strict gradients; `overrides` change the file.
  static RolloutModel Load(std::vector<std::string> overrides = {}) {
    LoadedScenario scenario = LoadScenario(KNAP_CONFIGS "/reaching_policy.yaml", overrides);
    CheckModel(scenario);
    EXPECT_TRUE(scenario.parsed.ok()) << scenario.parsed.FormatErrors();
    return RolloutModel(scenario.files);
  }

  static VectorXd MakeWeights(int n) {
    VectorXd w(n);
    for (Eigen::Index i = 0; i < n; ++i) w(i) = 0.5 * std::sin(1.0 + 2.3 * static_cast<double>(i));
    return w;
  }

  static RolloutOutput Run(RolloutModel& model, const VectorXd& theta, const VectorXd& weights, double y, double z,
                           bool gradient) {
    RolloutInput input;
    input.theta = theta;
    input.controls = weights;
    input.variation = {y, z};
    input.want_gradient = gradient;
    return model.Run(input, {});
  }

  const VectorXd theta_ = (VectorXd(9) << 1.2, 0.9, 0.8, 1.1, 0.6, 0.7, 1.3, 0.8, 1.5).finished();
};

TEST_F(ReachingPolicyTest, GradientInDesignAndWeightsIsThatOfDifferences) {
  RolloutModel model = Load();
  ASSERT_EQ(model.num_controls(), 12 * 14 + 4 * 13);
  const int n = model.num_controls();
  const VectorXd w = MakeWeights(n);
  const RolloutOutput out = Run(model, theta_, w, 0.04, -0.03, true);
  ASSERT_TRUE(out.certificate.converged);
  EXPECT_TRUE(out.gradient_reliable);
  VectorXd x(9 + n), g(9 + n);
  x << theta_, w;
  g << out.gradient, out.control_gradient;
  const auto evaluate = [&](const VectorXd& at) { return Run(model, at.head(9), at.tail(n), 0.04, -0.03, false).loss; };
  double worst = 0.0;
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    EXPECT_NE(g(i), 0.0) << i;
    if (i >= 9 && i % 5 != 0) continue;  // every fifth weight
    double best = 1e300;
    for (const double h : {1e-2, 3e-3, 1e-3, 3e-4}) {
      best = std::min(best, std::abs(test::CalcDifference(evaluate, x, i, h) - g(i)));
    }
    worst = std::max(worst, best);
  }
  EXPECT_LE(worst, 1e-7 * g.lpNorm<Eigen::Infinity>());
  EXPECT_GT(g.head(9).norm(), 0.0);
}

// A loss of the commands alone puts nothing on any state, yet they depend on states, weights and design.
TEST_F(ReachingPolicyTest, WhatCommandsCostGoesThroughTheStates) {
  RolloutModel model = Load({"loss.task[1].weight=0"});
  const int n = model.num_controls();
  const VectorXd w = MakeWeights(n);
  const RolloutOutput out = Run(model, theta_, w, 0.04, -0.03, true);
  const auto evaluate = [&](const VectorXd& theta) { return Run(model, theta, w, 0.04, -0.03, false).loss; };
  const double scale = out.gradient.lpNorm<Eigen::Infinity>();
  EXPECT_GT(scale, 1e-4);
  for (Eigen::Index i = 0; i < 9; ++i) {
    EXPECT_NEAR(test::CalcDifference(evaluate, theta_, i, 1e-3), out.gradient(i), 1e-7 * scale) << i;
  }
}

TEST_F(ReachingPolicyTest, TheGoalIsObserved) {
  // Without weights for the two inputs of the goal, and without its cost, the goal is nowhere.
  RolloutModel model = Load({"loss.task[1].weight=0"});
  VectorXd w = MakeWeights(model.num_controls());
  const double here = Run(model, theta_, w, 0.04, -0.03, false).loss;
  EXPECT_NE(here, Run(model, theta_, w, 0.02, -0.03, false).loss);
  EXPECT_NE(here, Run(model, theta_, w, 0.04, 0.03, false).loss);
  for (int unit = 0; unit < 12; ++unit) w.segment<2>(13 * unit + 11).setZero();
  EXPECT_EQ(Run(model, theta_, w, 0.04, -0.03, false).loss, Run(model, theta_, w, 0.02, 0.03, false).loss);
}

TEST_F(ReachingPolicyTest, WrongNumbersOfWeightsAreRefused) {
  RolloutModel model = Load();
  EXPECT_THROW(Run(model, theta_, MakeWeights(219), 0.0, 0.0, false), std::invalid_argument);
}

}  // namespace reaching_policy_test
}  // namespace knap
