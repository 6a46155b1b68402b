// The network against numbers worked out by hand and its pull-back against differences.
#include "sim/policy/network.h"

#include <gtest/gtest.h>

#include <cmath>

namespace knap {
namespace {

using Eigen::VectorXd;

VectorXd MakeWave(int n, double phase) {
  return VectorXd::NullaryExpr(n, [&](Eigen::Index i) { return std::sin(phase + 1.7 * static_cast<double>(i)); });
}

// y = s(w1 tanh(w0 x + b0) + b1), and its derivatives by the chain rule.
TEST(Network, OneUnitIsItsFormula) {
  for (const bool squashed : {false, true}) {
    Network network(1, {1}, 1, squashed);
    ASSERT_EQ(network.num_weights(), 4);
    const double w0 = 0.7, b0 = -0.2, w1 = 1.3, b1 = 0.4, x = 0.9;
    const VectorXd weights = (VectorXd(4) << w0, b0, w1, b1).finished();
    const double h = std::tanh(w0 * x + b0);
    const double a = w1 * h + b1;
    EXPECT_NEAR(network.Calc(weights, VectorXd::Constant(1, x))(0), squashed ? std::tanh(a) : a, 1e-15);
    VectorXd bar_weights = VectorXd::Constant(4, 0.5);  // it adds
    VectorXd bar_inputs = VectorXd::Constant(1, -1.0);
    network.PullBack(weights, VectorXd::Constant(1, x), VectorXd::Constant(1, 2.0), &bar_weights, &bar_inputs);
    const double slope = 2.0 * (squashed ? 1.0 - std::tanh(a) * std::tanh(a) : 1.0);
    const double inner = slope * w1 * (1.0 - h * h);
    const VectorXd expected = (VectorXd(4) << inner * x, inner, slope * h, slope).finished();
    EXPECT_LE((bar_weights - expected - VectorXd::Constant(4, 0.5)).norm(), 1e-15);
    EXPECT_NEAR(bar_inputs(0), inner * w0 - 1.0, 1e-15);
  }
}

// Without a hidden layer: rows of W, then b.
TEST(Network, WithoutHiddenLayersIsAffine) {
  Network network(2, {}, 3, false);
  const VectorXd weights = (VectorXd(9) << 1, 2, 3, 4, 5, 6, 0.1, 0.2, 0.3).finished();
  EXPECT_EQ(network.Calc(weights, Eigen::Vector2d(10.0, 1.0)), Eigen::Vector3d(12.1, 34.2, 56.3));
  EXPECT_EQ(network.ListFanIns(), (std::vector<int>{2, 2, 2, 2, 2, 2, 0, 0, 0}));
}

TEST(Network, PullBackIsThatOfDifferences) {
  for (const bool squashed : {false, true}) {
    Network network(3, {5, 4}, 2, squashed);
    ASSERT_EQ(network.num_weights(), 5 * 4 + 4 * 6 + 2 * 5);
    const VectorXd weights = MakeWave(network.num_weights(), 0.3);
    const VectorXd inputs = MakeWave(3, 1.1);
    const Eigen::Vector2d bar(0.8, -1.3);
    VectorXd bar_weights = VectorXd::Zero(network.num_weights());
    VectorXd bar_inputs = VectorXd::Zero(3);
    network.PullBack(weights, inputs, bar, &bar_weights, &bar_inputs);
    VectorXd x(weights.size() + 3), g(weights.size() + 3);
    x << weights, inputs;
    g << bar_weights, bar_inputs;
    EXPECT_TRUE((g.array() != 0.0).all());
    const auto f = [&](const VectorXd& at) { return bar.dot(network.Calc(at.head(weights.size()), at.tail(3))); };
    for (Eigen::Index i = 0; i < x.size(); ++i) {
      const double h = 1e-3;
      const auto at = [&](double step) {
        VectorXd moved = x;
        moved(i) += step;
        return f(moved);
      };
      // Five-point differences err by h⁴/30 times the fifth derivative.
      const double slope = (8.0 * (at(h) - at(-h)) - (at(2.0 * h) - at(-2.0 * h))) / (12.0 * h);
      EXPECT_NEAR(slope, g(i), 1e-10) << i;
    }
  }
}

}  // namespace
}  // namespace knap
