#include "coordinator/run/loss_unit.h"

#include <gtest/gtest.h>

#include "coordinator/run/loaded_run.h"

namespace knap {
namespace loss_unit_test {

Term MakeTerm(const std::string& signal, TermShape shape = TermShape::kSquare) {
  Term term;
  term.signals = {signal};
  term.shape = shape;
  return term;
}

std::string FormatUnitOf(const char* config, std::vector<std::string> overrides = {}) {
  return FormatLossUnit(LoadValidScenario(std::string(KNAP_SOURCE_DIR "/configs/") + config, overrides).parsed.scene);
}

TEST(LossUnitTest, SquaresOfLengthsHaveASquareUnit) {
  EXPECT_EQ(FormatUnitOf("pushing.yaml"), " m²");
  EXPECT_EQ(FormatUnitOf("pushing.yaml", {"loss.task[0].scale=1 mm"}), " mm²");
  EXPECT_EQ(FormatUnitOf("pushing.yaml", {"loss.task[0].scale=30 mm"}), " (3 cm)²");
}

TEST(LossUnitTest, TermsOfSeveralKindsNameTheLength) {
  EXPECT_EQ(FormatUnitOf("reaching.yaml"), " (lengths in cm)");  // distances and squared commands
}

TEST(LossUnitTest, WithoutAOneLengthThereIsNone) {
  Scene scene;
  EXPECT_EQ(FormatLossUnit(scene), "");
  scene.signals = {{"u", CommandSignal{}}, {"away", DistanceSignal{}}, {"x", PositionSignal{}}};
  scene.loss.task = {MakeTerm("u")};
  EXPECT_EQ(FormatLossUnit(scene), "");
  scene.loss.task = {MakeTerm("away", TermShape::kAbsolute), MakeTerm("x")};
  EXPECT_EQ(FormatLossUnit(scene), " (lengths in m)");
  scene.loss.task[0].scale = 0.01;
  EXPECT_EQ(FormatLossUnit(scene), "");
  scene.loss.task.pop_back();
  EXPECT_EQ(FormatLossUnit(scene), " cm");
}

TEST(LossUnitTest, OtherUnitsThanLengthsCountToo) {
  Scene scene;
  scene.signals = {{"spin", AngularVelocitySignal{}}, {"away", DistanceSignal{}}};
  scene.loss.task = {MakeTerm("spin")};
  EXPECT_EQ(FormatLossUnit(scene), " (rad/s)²");
  scene.loss.task.push_back(MakeTerm("spin", TermShape::kLog));
  EXPECT_EQ(FormatLossUnit(scene), " (counted in rad/s)");
  scene.loss.task.push_back(MakeTerm("away"));
  EXPECT_EQ(FormatLossUnit(scene), "");
  scene.loss.task = {MakeTerm("away", TermShape::kSaturating)};
  EXPECT_EQ(FormatLossUnit(scene), "");
}

}  // namespace loss_unit_test
}  // namespace knap
