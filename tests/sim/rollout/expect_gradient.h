// A rollout's design gradient against differences of its loss.
#pragma once

#include <gtest/gtest.h>

#include <cmath>

#include "sim/rollout/rollout.h"
#include "tests/sim/rollout/differences.h"

namespace knap::test {

// At a theta where bodies touch; every parameter's slope to 1e-4 of itself, by differences over `step`.
inline void ExpectGradient(RolloutModel* model, const Eigen::VectorXd& theta, double step) {
  RolloutInput input;
  input.theta = theta;
  input.want_gradient = true;
  const RolloutOutput out = model->Run(input, {});
  ASSERT_TRUE(out.certificate.converged);
  EXPECT_GT(out.certificate.contact_onsets, 0);
  const auto calc_loss = [&](const Eigen::VectorXd& at) {
    RolloutInput moved;
    moved.theta = at;
    return model->Run(moved, {}).loss;
  };
  ASSERT_EQ(out.gradient.size(), theta.size());
  for (Eigen::Index i = 0; i < theta.size(); ++i) {
    const double difference = CalcDifference(calc_loss, theta, i, step);
    EXPECT_GT(std::abs(difference), 1e-7);
    EXPECT_NEAR(out.gradient(i), difference, 1e-4 * std::abs(difference)) << "parameter " << i;
  }
}

}  // namespace knap::test
