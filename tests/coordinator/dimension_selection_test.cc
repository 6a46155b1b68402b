#include "coordinator/learning/dimension_selection.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>
#include <vector>

namespace knap {
namespace dimension_selection_test {

using Indices = std::vector<std::size_t>;
const double kDecay = std::exp(-1.0);

TEST(DimensionSelectionTest, TakesTheLargestUnusedThenRestartsAndDecays) {
  DimensionSelection selection(7, 2, 0.25, kDecay);
  const std::vector<double> g = {0.1, -7.0, 3.0, 0.5, -0.2, 6.0, 2.0};
  EXPECT_EQ(selection.Choose(g).dimensions, (Indices{1, 5}));
  EXPECT_EQ(selection.Choose(g).dimensions, (Indices{2, 6}));
  EXPECT_EQ(selection.Choose(g).dimensions, (Indices{3, 4}));
  const DimensionChoice last = selection.Choose(g);
  EXPECT_EQ(last.dimensions, (Indices{0}));  // fewer than d' are left: those alone move
  EXPECT_FALSE(last.restarted);
  EXPECT_EQ(last.learning_rate, 0.25);
  const DimensionChoice first_again = selection.Choose(g);
  EXPECT_TRUE(first_again.restarted);
  EXPECT_EQ(first_again.dimensions, (Indices{1, 5}));
  EXPECT_DOUBLE_EQ(first_again.learning_rate, 0.25 * kDecay);
  EXPECT_EQ(selection.restarts(), 1);
}

TEST(DimensionSelectionTest, DecaysOnceForEachRestart) {
  DimensionSelection selection(3, 3, 0.25, kDecay);
  for (int restart = 0; restart < 5; ++restart) {
    EXPECT_NEAR(selection.Choose(std::vector<double>{1, 2, 3}).learning_rate, 0.25 * std::exp(-restart), 1e-15);
  }
}

TEST(DimensionSelectionTest, FollowsTheGradientOfEachBatch) {
  DimensionSelection selection(4, 1, 0.25, kDecay);
  EXPECT_EQ(selection.Choose(std::vector<double>{1, 2, 3, 4}).dimensions, (Indices{3}));
  EXPECT_EQ(selection.Choose(std::vector<double>{5, 2, 3, 9}).dimensions, (Indices{0}));
  EXPECT_EQ(selection.Choose(std::vector<double>{5, 2, 1, 9}).dimensions, (Indices{1}));
}

TEST(DimensionSelectionTest, TiesGoByIndex) {
  DimensionSelection selection(5, 3, 0.25, kDecay);
  EXPECT_EQ(selection.Choose(std::vector<double>{-1, 2, 1, -2, 1}).dimensions, (Indices{1, 3, 0}));
}

TEST(DimensionSelectionTest, AZeroGradientMarksNothing) {
  DimensionSelection selection(4, 2, 0.25, kDecay);
  EXPECT_EQ(selection.Choose(std::vector<double>{4, 3, 2, 1}).dimensions, (Indices{0, 1}));
  const DimensionChoice flat = selection.Choose(std::vector<double>{0, 0.0, -0.0, 0});
  EXPECT_TRUE(flat.dimensions.empty());
  EXPECT_FALSE(flat.restarted);
  EXPECT_EQ(selection.Choose(std::vector<double>{4, 3, 2, 1}).dimensions, (Indices{2, 3}));
}

TEST(DimensionSelectionTest, DimensionsWithoutSlopeStayAvailable) {
  DimensionSelection selection(4, 2, 0.25, kDecay);
  EXPECT_EQ(selection.Choose(std::vector<double>{0, 0, 2, 0}).dimensions, (Indices{2}));
  EXPECT_EQ(selection.Choose(std::vector<double>{1, 5, 9, 3}).dimensions, (Indices{1, 3}));
  EXPECT_EQ(selection.Choose(std::vector<double>{1, 5, 9, 3}).dimensions, (Indices{0}));
}

TEST(DimensionSelectionTest, AParameterWithoutInfluenceCannotStopTheSchedule) {
  DimensionSelection selection(3, 1, 0.25, kDecay);
  const std::vector<double> g = {2, 0, 1};
  std::vector<Indices> chosen;
  for (int t = 0; t < 5; ++t) chosen.push_back(selection.Choose(g).dimensions);
  EXPECT_EQ(chosen, (std::vector<Indices>{{0}, {2}, {0}, {2}, {0}}));
  EXPECT_EQ(selection.restarts(), 2);
}

TEST(DimensionSelectionTest, RefusesAGradientOfAnotherLength) {
  DimensionSelection selection(3, 1, 0.25, kDecay);
  EXPECT_THROW(selection.Choose(std::vector<double>{1, 2}), std::invalid_argument);
}

}  // namespace dimension_selection_test
}  // namespace knap
