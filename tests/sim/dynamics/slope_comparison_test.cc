// The judge of gradients, judged: it confirms right slopes and no others.
#include "tests/sim/dynamics/slope_comparison.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace knap {
namespace slope_comparison_test {

using test::CheckTaylorRemainder;
using test::SlopeComparison;
using testing::HasSubstr;
using testing::IsEmpty;

double Smooth(double s) { return std::exp(0.7 * s) + 3.0 * std::sin(s); }
constexpr double kSlope = 3.7;

// Once differentiable at 0, where its second derivative jumps.
double Bent(double s) { return 2.0 * s + (s > 0.0 ? 5.0 * s * s : 0.0); }

TEST(SlopeComparison, ConfirmsRightSlopes) {
  SlopeComparison comparison;
  comparison.Add("smooth", kSlope, Smooth);
  comparison.Add("bent", 2.0, Bent, 1e-3);
  comparison.Add("nothing", 0.0, [](double) { return 1.0; });
  std::map<std::string, int> compared;
  EXPECT_THAT(comparison.Compare(1e-7, &compared), IsEmpty());
  EXPECT_EQ(compared, (std::map<std::string, int>{{"bent", 1}, {"smooth", 1}}));
}

TEST(SlopeComparison, SeesAnErrorJustBeyondTheTolerance) {
  SlopeComparison comparison;
  comparison.Add("smooth", kSlope * (1.0 + 1.2e-6), Smooth);
  EXPECT_THAT(comparison.Compare(1e-6, nullptr), HasSubstr("smooth: slope"));
  EXPECT_THAT(comparison.Compare(1.5e-6, nullptr), IsEmpty());
}

TEST(SlopeComparison, DoesNotTakeZeroForAgreement) {
  SlopeComparison comparison;
  comparison.Add("nothing", 0.0, [](double) { return 1.0; });
  EXPECT_THAT(comparison.Compare(1e-7, nullptr), HasSubstr("zero"));
}

// Differences of a jump pass through every slope: at one step they equal this one, at its neighbours they do not.
TEST(SlopeComparison, DoesNotTakeOneStepForAPlateau) {
  const double h = std::ldexp(1.0, -20);
  SlopeComparison comparison;
  comparison.Add("jump", 1.0, [h](double s) { return s > 0.0 ? 2.0 * h : 0.0; });
  EXPECT_THAT(comparison.Compare(1e-5, nullptr), HasSubstr("jump"));
}

TEST(TaylorRemainder, FallsAsTheSquareForTheRightSlopeAlone) {
  EXPECT_THAT(CheckTaylorRemainder(kSlope, Smooth), IsEmpty());
  EXPECT_THAT(CheckTaylorRemainder(kSlope * (1.0 + 1e-3), Smooth), HasSubstr("orders"));
  EXPECT_THAT(CheckTaylorRemainder(0.0, [](double) { return 1.0; }), HasSubstr("orders"));
  EXPECT_THAT(CheckTaylorRemainder(2.0, [](double s) { return 2.0 * s; }), HasSubstr("orders"));
}

}  // namespace slope_comparison_test
}  // namespace knap
