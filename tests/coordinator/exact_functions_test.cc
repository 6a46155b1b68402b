// The elementary functions of exactly rounded operations against those of the library.
#include "coordinator/random/exact_functions.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace knap {
namespace exact_functions_test {

TEST(ExactFunctions, EqualTheLibrarysToRounding) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  for (int i = 0; i < 20000; ++i) {
    const double x = unit(random), y = unit(random);
    EXPECT_NEAR(CalcLogarithm(std::exp(600.0 * x)), 600.0 * x, 2e-13);
    EXPECT_NEAR(CalcExponential(30.0 * x) / std::exp(30.0 * x), 1.0, 3e-14);
    EXPECT_NEAR(CalcArcTangent(y, x), std::atan2(y, x), 1e-14);
    double sine = 0.0, cosine = 0.0;
    CalcSineCosine(20.0 * x, &sine, &cosine);
    EXPECT_NEAR(sine, std::sin(20.0 * x), 1e-14);
    EXPECT_NEAR(cosine, std::cos(20.0 * x), 1e-14);
  }
}

TEST(ExactFunctions, AreExactWhereItMatters) {
  EXPECT_EQ(CalcExponential(0.0), 1.0);
  EXPECT_EQ(CalcLogarithm(1.0), 0.0);
  EXPECT_EQ(CalcArcTangent(0.0, 0.0), 0.0);
  EXPECT_EQ(CalcArcTangent(0.0, 2.0), 0.0);
  EXPECT_DOUBLE_EQ(CalcArcTangent(3.0, 0.0), 0.5 * std::numbers::pi);
  EXPECT_DOUBLE_EQ(CalcArcTangent(-3.0, 0.0), -0.5 * std::numbers::pi);
  EXPECT_DOUBLE_EQ(CalcArcTangent(0.0, -1.0), std::numbers::pi);
}

}  // namespace exact_functions_test
}  // namespace knap
