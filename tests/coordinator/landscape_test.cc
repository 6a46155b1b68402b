// Slices of a quadratic, whose values, contours and least point are known.
#include "coordinator/landscape/landscape.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

#include "tests/coordinator/closed_form_service.h"

namespace knap {
namespace landscape_test {

using testing::ElementsAre;

// theta = (a, b, c); the slice runs over c (x) and a (y).
const ParameterSpec kParameters{{"a", "b", "c"}, {0.0, -1.0, 0.1}, {1.0, 1.0, 0.7}, {0.5, 0.0, 0.3}, {"m", "m", ""}};

QuadraticService MakeService() { return {{1.0, 2.0, 4.0}, {0.25, 0.5, 0.4}}; }

LandscapePlan MakePlan() {
  return {MakeAxis(kParameters, 2, 4), MakeAxis(kParameters, 0, 3), {0.5, 0.2, 0.3}, {{0, 0, 0}, {0.1, -0.2, 0.3}}};
}

TEST(LandscapeTest, AxesRunFromBoundToBound) {
  const LandscapeAxis axis = MakeAxis(kParameters, 2, 4);
  EXPECT_EQ(axis.parameter, 2u);
  ASSERT_EQ(axis.values.size(), 4u);
  EXPECT_EQ(axis.values.front(), 0.1);
  EXPECT_NEAR(axis.values[1], 0.3, 1e-15);  // rounding of one step
  EXPECT_EQ(axis.values.back(), 0.7);
}

TEST(LandscapeTest, CellsAreMeansOverTheVariations) {
  QuadraticService service = MakeService();
  const Landscape landscape = EvaluateLandscape(MakePlan(), service);
  ASSERT_EQ(service.calls.size(), 1u);  // nobody idles between cells
  EXPECT_EQ(service.calls[0].size(), 24u);
  EXPECT_EQ(CalcRolloutCount(landscape.plan), 24);
  ASSERT_EQ(landscape.cells.size(), 12u);
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 4; ++j) {
      const double a = 0.5 * static_cast<double>(i), c = 0.1 + 0.2 * static_cast<double>(j);
      const auto square = [](double x) { return x * x; };
      const double first = square(a - 0.25) + 2.0 * square(0.2 - 0.5) + 4.0 * square(c - 0.4);
      const double second = square(a - 0.35) + 2.0 * square(0.2 - 0.3) + 4.0 * square(c - 0.7);
      EXPECT_NEAR(landscape.at(i, j).loss, 0.5 * (first + second), 1e-14);  // a few roundings of numbers near 1
      EXPECT_EQ(landscape.at(i, j).success_rate, 0.5 * (first < 0.1) + 0.5 * (second < 0.1));
    }
  }
}

TEST(LandscapeTest, DistrustIsCountedAndNeverFlatters) {
  QuadraticService service = MakeService();
  int asked = 0;
  std::vector<double> losses;
  service.spoil = [&](const RolloutQuery&, RolloutOutcome& outcome) {
    losses.push_back(outcome.loss);
    outcome.success = true;
    outcome.certificate.subdivided_steps = 2;
    const int k = asked++;
    if (k == 0 || k == 2 || k == 3) outcome.loss = std::numeric_limits<double>::quiet_NaN();
    if (k == 4) outcome.certificate.converged = false;
  };
  const Landscape landscape = EvaluateLandscape(MakePlan(), service);
  EXPECT_EQ(landscape.cells[0].loss, losses[1]);
  EXPECT_EQ(landscape.cells[0].not_finite, 1);
  EXPECT_EQ(landscape.cells[0].success_rate, 0.5);
  EXPECT_EQ(landscape.cells[1].loss, std::numeric_limits<double>::infinity());
  EXPECT_DOUBLE_EQ(landscape.cells[2].loss, 0.5 * (losses[5] + std::max(losses[4], losses[5])));
  EXPECT_EQ(landscape.cells[1].not_finite, 2);
  EXPECT_EQ(landscape.cells[2].not_converged, 1);
  EXPECT_EQ(landscape.cells[2].success_rate, 0.5);
  EXPECT_EQ(landscape.cells[2].subdivided_steps, 4);
  EXPECT_EQ(landscape.cells[3].success_rate, 1.0);
}

TEST(LandscapeTest, CsvReadsBackToTheSameBits) {
  QuadraticService service = MakeService();
  const Landscape landscape = EvaluateLandscape(MakePlan(), service);
  std::istringstream lines(MakeLandscapeCsv(landscape, kParameters));
  std::string line;
  std::getline(lines, line);
  EXPECT_EQ(line, "c,a,loss,success_rate,variations,not_finite,not_converged,worst_residual,subdivided_steps");
  for (std::size_t k = 0; k < 12; ++k) {
    ASSERT_TRUE(std::getline(lines, line));
    std::vector<double> fields;
    std::istringstream text(line);
    for (std::string field; std::getline(text, field, ',');) fields.push_back(std::stod(field));
    const LandscapeCell& cell = landscape.cells[k];
    EXPECT_THAT(fields, ElementsAre(landscape.plan.x.values[k % 4], landscape.plan.y.values[k / 4], cell.loss,
                                    cell.success_rate, 2, 0, 0, cell.worst_residual, 0));
  }
  EXPECT_FALSE(std::getline(lines, line));
}

TEST(LandscapeTest, PlansThatAreNoneAreRefused) {
  QuadraticService service = MakeService();
  LandscapePlan plan = MakePlan();
  plan.y.parameter = 2;
  EXPECT_THROW(EvaluateLandscape(plan, service), std::invalid_argument);
  plan = MakePlan();
  plan.x.parameter = 3;
  EXPECT_THROW(EvaluateLandscape(plan, service), std::invalid_argument);
  plan = MakePlan();
  plan.variations.clear();
  EXPECT_THROW(EvaluateLandscape(plan, service), std::invalid_argument);
}

}  // namespace landscape_test
}  // namespace knap
