// The predictor on sequences whose next member is known.
#include "sim/integrators/acceleration_predictor.h"

#include <gtest/gtest.h>

#include <cmath>

namespace knap {
namespace {

using Eigen::Vector2d;
using Eigen::VectorXd;

constexpr double kStep = 0.1;

VectorXd Predict(const AccelerationPredictor& predictor, double h = kStep) {
  VectorXd a = VectorXd::Constant(2, 7.0);
  predictor.Predict(h, &a);
  return a;
}

TEST(AccelerationPredictor, StartsAtZeroAndThenAtTheLastOne) {
  AccelerationPredictor predictor(2);
  EXPECT_EQ(Predict(predictor), Vector2d::Zero());
  predictor.Push(kStep, Vector2d(1.0, -2.0));
  EXPECT_EQ(Predict(predictor), Vector2d(1.0, -2.0));
}

TEST(AccelerationPredictor, ContinuesPolynomialsUpToItsDegree) {
  const auto cubic = [](double t) { return Vector2d(1.0 + t * (2.0 + t * (3.0 - 4.0 * t)), 5.0 - t * t); };
  AccelerationPredictor predictor(2);
  // Degree 3 shows itself with the fifth: until then there is no miss to judge it by.
  for (int k = 0; k < 5; ++k) predictor.Push(kStep, cubic(k * kStep));
  EXPECT_LT((Predict(predictor) - cubic(5 * kStep)).norm(), 1e-13);
}

TEST(AccelerationPredictor, ExtrapolatesNothingAcrossAJolt) {
  AccelerationPredictor predictor(2);
  for (int k = 0; k < 8; ++k) predictor.Push(kStep, Vector2d(k, 2.0 * k));
  predictor.Push(kStep, Vector2d(1000.0, 0.0));
  EXPECT_EQ(Predict(predictor), Vector2d(1000.0, 0.0));
}

TEST(AccelerationPredictor, ExtrapolatesOverEqualStepsAlone) {
  AccelerationPredictor predictor(2);
  for (int k = 0; k < 8; ++k) predictor.Push(kStep, Vector2d(k, 2.0 * k));
  EXPECT_LT((Predict(predictor) - Vector2d(8.0, 16.0)).norm(), 1e-12);
  EXPECT_EQ(Predict(predictor, 0.5 * kStep), Vector2d(7.0, 14.0));
  predictor.Push(0.5 * kStep, Vector2d(3.0, 3.0));
  EXPECT_EQ(Predict(predictor, 0.5 * kStep), Vector2d(3.0, 3.0));
  predictor.Clear();
  EXPECT_EQ(Predict(predictor), Vector2d::Zero());
}

}  // namespace
}  // namespace knap
