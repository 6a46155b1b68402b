// What each distribution draws: its moments, its bounds, and what is refused.
#include "coordinator/learning/variation_draws.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <vector>

namespace knap {
namespace variation_draws_test {

using std::numbers::pi;
using testing::HasSubstr;
constexpr int kDraws = 20000;

std::vector<std::vector<double>> DrawMany(const VariationKeys& keys) {
  EXPECT_EQ(FindDrawFault(keys), "");
  std::vector<std::vector<double>> draws;
  for (int i = 0; i < kDraws; ++i) {
    draws.push_back(SampleVariation({keys}, 5, RandomStream::kTrainingVariations, static_cast<std::uint64_t>(i)));
    EXPECT_EQ(draws.back().size(), keys.names.size());
  }
  std::vector<DrawRange> ranges;
  AddDrawRanges(keys, &ranges);
  EXPECT_EQ(ranges.size(), keys.names.size());
  return draws;
}

template <class F>
double CalcMean(const std::vector<std::vector<double>>& draws, const F& f) {
  double sum = 0.0;
  for (const std::vector<double>& draw : draws) sum += f(draw);
  return sum / static_cast<double>(draws.size());
}

TEST(VariationDraws, OfALogUniformNumberHasAUniformLogarithm) {
  const auto draws = DrawMany({{"x"}, LogUniformDraw{0.1, 1000.0}});
  EXPECT_NEAR(CalcMean(draws, [](const auto& x) { return std::log10(x[0]); }), 1.0, 0.03);
  EXPECT_NEAR(CalcMean(draws, [](const auto& x) { return x[0] < 1.0 ? 1.0 : 0.0; }), 0.25, 0.02);
  for (const auto& x : draws) EXPECT_TRUE(x[0] >= 0.1 && x[0] <= 1000.0);
}

TEST(VariationDraws, OfAChoiceAreItsValuesEachAsOften) {
  const auto draws = DrawMany({{"x"}, ChoiceDraw{{1.0, 2.0, 5.0}}});
  for (const double value : {1.0, 2.0, 5.0}) {
    EXPECT_NEAR(CalcMean(draws, [&](const auto& x) { return x[0] == value ? 1.0 : 0.0; }), 1.0 / 3.0, 0.015);
  }
}

// Of r²: half the square of the radius in two dimensions, three fifths in three.
TEST(VariationDraws, OfDiscsAndBallsFillThemEvenly) {
  for (const int n : {2, 3}) {
    BallDraw ball{std::vector<double>(static_cast<std::size_t>(n), 3.0), 2.0};
    const std::vector<std::string> names =
        n == 2 ? std::vector<std::string>{"x", "y"} : std::vector<std::string>{"x", "y", "z"};
    const auto draws = DrawMany({names, ball});
    const auto r2 = [](const auto& x) {
      double sum = 0.0;
      for (const double c : x) sum += (c - 3.0) * (c - 3.0);
      return sum;
    };
    EXPECT_NEAR(CalcMean(draws, r2), n == 2 ? 2.0 : 2.4, 0.03) << n;
    EXPECT_NEAR(CalcMean(draws, [](const auto& x) { return x[0]; }), 3.0, 0.02) << n;
    for (const auto& x : draws) EXPECT_LE(r2(x), 4.0 * (1.0 + 1e-12));
  }
}

// The body's axes point everywhere alike: each entry of the rotation matrix has mean 0 and mean square 1/3.
TEST(VariationDraws, OfOrientationsAreUniform) {
  const auto draws = DrawMany({{"roll", "pitch", "yaw"}, OrientationDraw{}});
  const auto entry = [](const std::vector<double>& rpy, int i, int j) {
    const double cr = std::cos(rpy[0]), sr = std::sin(rpy[0]), cp = std::cos(rpy[1]), sp = std::sin(rpy[1]),
                 cy = std::cos(rpy[2]), sy = std::sin(rpy[2]);
    const double R[3][3] = {{cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr},
                            {sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr},
                            {-sp, cp * sr, cp * cr}};
    return R[i][j];
  };
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      EXPECT_NEAR(CalcMean(draws, [&](const auto& x) { return entry(x, i, j); }), 0.0, 0.02);
      EXPECT_NEAR(CalcMean(draws, [&](const auto& x) { return entry(x, i, j) * entry(x, i, j); }), 1.0 / 3.0, 0.01);
    }
  }
  // So is the angle's distribution: its mean is pi/2 + 2/pi.
  const auto angle = [&](const auto& x) {
    return std::acos(std::clamp(0.5 * (entry(x, 0, 0) + entry(x, 1, 1) + entry(x, 2, 2) - 1.0), -1.0, 1.0));
  };
  EXPECT_NEAR(CalcMean(draws, angle), pi / 2 + 2 / pi, 0.02);
}

TEST(VariationDraws, OfTurnsAboutAnAxisHaveItsAngle) {
  for (const auto& x : DrawMany({{"roll", "pitch", "yaw"}, TurnDraw{{0.0, 0.0, 2.0}, -0.5, 1.0}})) {
    EXPECT_NEAR(x[0], 0.0, 1e-15);
    EXPECT_NEAR(x[1], 0.0, 1e-15);
    EXPECT_TRUE(x[2] >= -0.5 - 1e-14 && x[2] <= 1.0 + 1e-14);
  }
  const auto draws = DrawMany({{"roll", "pitch", "yaw"}, TurnDraw{{3.0, 0.0, 0.0}, 0.0, 1.0}});
  EXPECT_NEAR(CalcMean(draws, [](const auto& x) { return x[0]; }), 0.5, 0.01);
}

TEST(VariationDraws, OfCorrelatedNumbersHaveTheirMoments) {
  const double rho = 0.8;
  const auto draws = DrawMany(
      {{"a", "b"}, CorrelatedDraw{{1.0, -2.0}, {0.1, 3.0}, {{1.0, 0.0}, {rho, std::sqrt(1 - rho * rho)}}, 5.0}});
  EXPECT_NEAR(CalcMean(draws, [](const auto& x) { return x[0]; }), 1.0, 0.003);
  EXPECT_NEAR(CalcMean(draws, [](const auto& x) { return x[1]; }), -2.0, 0.08);
  EXPECT_NEAR(CalcMean(draws, [](const auto& x) { return (x[0] - 1.0) * (x[1] + 2.0); }) / 0.3, rho, 0.03);
  const auto close = DrawMany({{"a", "b"}, CorrelatedDraw{{0.0, 0.0}, {1.0, 1.0}, {{1.0, 0.0}, {rho, 0.6}}, 0.5}});
  for (const auto& x : close) EXPECT_LE(std::max(std::abs(x[0]), std::abs(x[1])), 0.5);
}

TEST(VariationDraws, OfATableAreItsRows) {
  const std::set<std::vector<double>> rows = {{1.0, 10.0}, {2.0, 20.0}, {4.0, 40.0}};
  std::set<std::vector<double>> seen;
  for (const auto& x : DrawMany({{"a", "b"}, RowDraw{{rows.begin(), rows.end()}}})) seen.insert(x);
  EXPECT_EQ(seen, rows);
}

TEST(VariationDraws, RefuseWhatIsNone) {
  EXPECT_THAT(FindDrawFault({{"x"}, LogUniformDraw{0.0, 1.0}}), HasSubstr("0 < lower <= upper"));
  EXPECT_THAT(FindDrawFault({{"x"}, ChoiceDraw{}}), HasSubstr("at least one"));
  EXPECT_THAT(FindDrawFault({{"x"}, BallDraw{{0.0, 0.0}, 1.0}}), HasSubstr("1 names for 2 numbers"));
  EXPECT_THAT(FindDrawFault({{"x", "y"}, BallDraw{{0.0, 0.0}, -1.0}}), HasSubstr("radius -1"));
  EXPECT_THAT(FindDrawFault({{"a", "b"}, OrientationDraw{}}), HasSubstr("for 3 numbers"));
  EXPECT_THAT(FindDrawFault({{"a", "b", "c"}, TurnDraw{}}), HasSubstr("an axis"));
  EXPECT_THAT(FindDrawFault({{"a", "b"}, CorrelatedDraw{{0.0}, {1.0, 1.0}, {}, 3.0}}), HasSubstr("equal numbers"));
  EXPECT_THAT(FindDrawFault({{"a"}, RowDraw{}}), HasSubstr("without a row"));
  EXPECT_THAT(FindDrawFault({{"a"}, RowDraw{{{1.0}, {1.0, 2.0}}}}), HasSubstr("for 2 numbers"));
}

}  // namespace variation_draws_test
}  // namespace knap
