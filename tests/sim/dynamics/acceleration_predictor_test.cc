// The predictor on sequences whose next member is known.
#include "sim/integrators/acceleration_predictor.h"

#include <gtest/gtest.h>

#include <cmath>

namespace knap {
namespace acceleration_predictor_test {

using Eigen::Vector2d;
using Eigen::VectorXd;

constexpr double kStep = 0.1;

VectorXd Predict(const AccelerationPredictor& predictor, double time) {
  VectorXd a = VectorXd::Constant(2, 7.0);
  predictor.Predict(time, &a);
  return a;
}

TEST(AccelerationPredictor, StartsAtZeroAndThenAtTheLastOne) {
  AccelerationPredictor predictor(2);
  EXPECT_EQ(Predict(predictor, 0.0), Vector2d::Zero());
  predictor.Push(0.0, Vector2d(1.0, -2.0));
  EXPECT_EQ(Predict(predictor, kStep), Vector2d(1.0, -2.0));
}

TEST(AccelerationPredictor, ContinuesPolynomialsUpToItsDegree) {
  const auto cubic = [](double t) { return Vector2d(1.0 + t * (2.0 + t * (3.0 - 4.0 * t)), 5.0 - t * t); };
  // Equal steps, and unequal ones.
  for (const double growth : {1.0, 1.3}) {
    AccelerationPredictor predictor(2);
    double time = 0.0;
    double h = kStep;
    // Degree 3 shows itself with the fifth: until then there is no miss to judge it by.
    for (int k = 0; k < 5; ++k, h *= growth, time += h) predictor.Push(time, cubic(time));
    EXPECT_LT((Predict(predictor, time) - cubic(time)).norm(), 1e-13 * std::exp(20.0 * (growth - 1.0))) << growth;
  }
}

TEST(AccelerationPredictor, ExtrapolatesNothingAcrossAJolt) {
  AccelerationPredictor predictor(2);
  for (int k = 0; k < 8; ++k) predictor.Push(k * kStep, Vector2d(k, 2.0 * k));
  predictor.Push(8 * kStep, Vector2d(1000.0, 0.0));
  EXPECT_EQ(Predict(predictor, 9 * kStep), Vector2d(1000.0, 0.0));
}

TEST(AccelerationPredictor, ForgetsWhenTold) {
  AccelerationPredictor predictor(2);
  for (int k = 0; k < 8; ++k) predictor.Push(k * kStep, Vector2d(k, 2.0 * k));
  EXPECT_LT((Predict(predictor, 7.5 * kStep) - Vector2d(7.5, 15.0)).norm(), 1e-12);
  predictor.Clear();
  EXPECT_EQ(Predict(predictor, 8 * kStep), Vector2d::Zero());
  predictor.Push(8 * kStep, Vector2d(3.0, 3.0));
  EXPECT_EQ(Predict(predictor, 9 * kStep), Vector2d(3.0, 3.0));
}

}  // namespace acceleration_predictor_test
}  // namespace knap
