// Contours, colours, round numbers, and the picture of a landscape made of them.
#include "coordinator/report/landscape_picture.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "coordinator/report/colour_map.h"
#include "coordinator/report/contour.h"

namespace knap {
namespace landscape_picture_test {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

// A circle sampled finely: the line's length and its points' distances are known.
TEST(ContourTest, CircleIsFound) {
  constexpr int kSize = 81;
  constexpr double kRadius = 25.0;
  Eigen::MatrixXd values(kSize, kSize);
  for (int i = 0; i < kSize; ++i) {
    for (int j = 0; j < kSize; ++j) values(i, j) = std::hypot(i - 40.0, j - 40.0);
  }
  double length = 0.0;
  for (const auto& [a, b] : CalcContour(values, kRadius)) {
    length += (b - a).norm();
    // Linear interpolation of a function with curvature 1/r errs by at most 1/(8 r) on an edge.
    EXPECT_NEAR((a - Eigen::Vector2d(40.0, 40.0)).norm(), kRadius, 1.0 / (8.0 * (kRadius - 1.0)));
  }
  EXPECT_NEAR(length, 2.0 * M_PI * kRadius, 0.005 * kRadius);  // chords and the same error
}

TEST(ContourTest, SaddleIsCutByItsMean) {
  Eigen::MatrixXd values(2, 2);
  values << 1.0, 0.0,  //
      0.0, 1.0;
  // The mean, 0.5, is above 0.4: the corners at 0 are cut off. It is below 0.6: those at 1 are.
  for (const auto& [level, is_corner_at_zero] : {std::pair(0.4, true), std::pair(0.6, false)}) {
    const std::vector<Segment> segments = CalcContour(values, level);
    ASSERT_EQ(segments.size(), 2u);
    for (const auto& [a, b] : segments) {
      const Eigen::Vector2d middle = 0.5 * (a + b);
      // Columns run right, rows up: 0 is at (1, 0) and (0, 1).
      EXPECT_EQ((middle.x() > 0.5) != (middle.y() > 0.5), is_corner_at_zero) << level;
    }
  }
}

TEST(ContourTest, HolesHaveNoLine) {
  Eigen::MatrixXd values(2, 3);
  values << 0.0, 1.0, 2.0,  //
      0.0, 1.0, std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(CalcContour(values, 0.5).size(), 1u);
  EXPECT_TRUE(CalcContour(values, 1.5).empty());
}

TEST(RoundNumbersTest, AreRoundAndWithin) {
  EXPECT_THAT(ListRoundNumbers(0.0, 40.0, 5), ElementsAre(0.0, 10.0, 20.0, 30.0, 40.0));
  EXPECT_THAT(ListRoundNumbers(-0.5, 40.5, 4), ElementsAre(0.0, 10.0, 20.0, 30.0, 40.0));
  EXPECT_THAT(ListRoundNumbers(-5.0, 5.0, 5), ElementsAre(-4.0, -2.0, 0.0, 2.0, 4.0));
  const std::vector<double> fine = ListRoundNumbers(100.0, 100.5, 5);
  ASSERT_EQ(fine.size(), 6u);
  for (std::size_t k = 0; k < 6; ++k) EXPECT_NEAR(fine[k], 100.0 + 0.1 * static_cast<double>(k), 1e-12);
}

double CalcLuminance(const std::string& colour) {
  const auto channel = [&](std::size_t at) {
    const double code = std::stoi(colour.substr(at, 2), nullptr, 16) / 255.0;
    return code <= 0.04045 ? code / 12.92 : std::pow((code + 0.055) / 1.055, 2.4);
  };
  return 0.2126 * channel(1) + 0.7152 * channel(3) + 0.0722 * channel(5);
}

// Read in grey the order must stay: that is what the map is for.
TEST(ColourMapTest, BrightensAllTheWay) {
  for (int k = 1; k <= 50; ++k)
    EXPECT_GT(CalcLuminance(MakeColour(0.02 * k)), CalcLuminance(MakeColour(0.02 * (k - 1))));
  EXPECT_LT(CalcLuminance(MakeColour(0.0)), 0.06);
  EXPECT_GT(CalcLuminance(MakeColour(1.0)), 0.75);
  EXPECT_EQ(MakeColour(-3.0), MakeColour(0.0));
  EXPECT_EQ(MakeColour(3.0), MakeColour(1.0));
}

Landscape MakeLandscape() {
  Landscape landscape;
  landscape.plan.x = {0, {0.0, 0.01, 0.02}};
  landscape.plan.y = {1, {-1.0, 1.0}};
  landscape.plan.theta = {0.01, 0.0};
  landscape.plan.variations = {{}};
  for (int k = 0; k < 6; ++k) landscape.cells.push_back({.loss = 1e-5 * (k + 1), .success_rate = 0.5});
  return landscape;
}
const ParameterSpec kSpec{{"depth", "control[0][hip]"}, {0.0, -1.0}, {0.02, 1.0}, {0.01, 0.0}, {"m", ""}};

int Count(const std::string& text, const std::string& what) {
  int count = 0;
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++count;
  return count;
}

TEST(LandscapePictureTest, ShowsUnitsCaptionAndBothPanels) {
  const std::string svg = DrawLandscape(MakeLandscape(), kSpec, {"pushing: a < b", "mean of 3", "initial", true});
  EXPECT_THAT(svg, AllOf(HasSubstr("<svg"), HasSubstr("pushing: a &lt; b"), HasSubstr("mean of 3"),
                         HasSubstr("depth [mm]"), HasSubstr(">control[0][hip]<"), HasSubstr("Mean loss [10⁻⁵]"),
                         HasSubstr("Success rate [%]"), HasSubstr(">initial<")));
  EXPECT_THAT(svg, AllOf(HasSubstr(">20</text>"), Not(HasSubstr("not to be trusted")), Not(HasSubstr("nan"))));
  const std::string one = DrawLandscape(MakeLandscape(), kSpec, {"reaching", "loss", "initial", false});
  EXPECT_THAT(one, Not(HasSubstr("Success rate")));
}

TEST(LandscapePictureTest, MarksWhatIsNotToBeTrusted) {
  Landscape landscape = MakeLandscape();
  landscape.cells[2].loss = std::numeric_limits<double>::infinity();
  landscape.cells[2].not_finite = 1;
  landscape.cells[4].not_converged = 1;
  const std::string svg = DrawLandscape(landscape, kSpec, {"t", "s", "initial", false});
  EXPECT_EQ(Count(svg, "url(#untrusted)"), 3);  // two cells and the legend
  EXPECT_THAT(svg, AllOf(HasSubstr("(2 cells)"), Not(HasSubstr("nan")), Not(HasSubstr("inf"))));
}

TEST(LandscapePictureTest, FlatAndEmptyLandscapes) {
  Landscape landscape = MakeLandscape();
  for (LandscapeCell& cell : landscape.cells) cell.loss = 2.0;
  EXPECT_THAT(DrawLandscape(landscape, kSpec, {"t", "s", "initial", false}), Not(HasSubstr("nan")));
  for (LandscapeCell& cell : landscape.cells) cell.loss = std::numeric_limits<double>::infinity();
  EXPECT_THROW(DrawLandscape(landscape, kSpec, {"t", "s", "initial", false}), std::runtime_error);
}

}  // namespace landscape_picture_test
}  // namespace knap
