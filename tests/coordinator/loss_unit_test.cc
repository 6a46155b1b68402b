#include "coordinator/cli/loss_unit.h"

#include <gtest/gtest.h>

#include "coordinator/cli/loaded_run.h"

namespace knap {
namespace {

std::string FormatUnitOf(const char* config, std::vector<std::string> overrides = {}) {
  return FormatLossUnit(LoadValidScenario(std::string(KNAP_SOURCE_DIR "/configs/") + config, overrides).parsed.scene);
}

TEST(LossUnitTest, SquaresOfLengthsHaveASquareUnit) {
  EXPECT_EQ(FormatUnitOf("pushing.yaml"), " m²");
  EXPECT_EQ(FormatUnitOf("pushing.yaml", {"loss.task[0].length_unit=1 mm"}), " mm²");
  EXPECT_EQ(FormatUnitOf("pushing.yaml", {"loss.task[0].length_unit=30 mm"}), " (0.03 m)²");
}

TEST(LossUnitTest, TermsOfSeveralKindsNameTheLength) {
  EXPECT_EQ(FormatUnitOf("reaching.yaml"), " (lengths in cm)");  // distances and squared commands
}

TEST(LossUnitTest, WithoutAOneLengthThereIsNone) {
  Scene scene;
  EXPECT_EQ(FormatLossUnit(scene), "");
  scene.loss.task = {ControlCostLoss{}};
  EXPECT_EQ(FormatLossUnit(scene), "");
  scene.loss.task = {PointTargetLoss{}, CrossingLoss{}};
  EXPECT_EQ(FormatLossUnit(scene), " (lengths in m)");
  std::get<PointTargetLoss>(scene.loss.task[0]).length_unit = 0.01;
  EXPECT_EQ(FormatLossUnit(scene), "");
  scene.loss.task.pop_back();
  EXPECT_EQ(FormatLossUnit(scene), " cm");
}

}  // namespace
}  // namespace knap
