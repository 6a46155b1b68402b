#include "coordinator/run/problem_from_scene.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <variant>

#include "coordinator/run/loaded_run.h"
#include "sim/scenarios/number_table.h"
namespace knap {
namespace problem_from_scene_test {

Scene LoadPushing() { return LoadValidScenario(KNAP_SOURCE_DIR "/configs/pushing.yaml", {}).parsed.scene; }

TEST(ProblemFromSceneTest, ParametersAndVariationsAreTheScenes) {
  const Problem problem = MakeProblem(LoadPushing());
  ASSERT_EQ(problem.parameters.names.size(), 7u);
  EXPECT_EQ(problem.parameters.names[3], "left_depth");
  EXPECT_EQ(problem.parameters.lower[3], -0.015);
  EXPECT_EQ(problem.parameters.upper[3], 0.04);
  EXPECT_EQ(problem.parameters.initial[0], 0.044);
  ASSERT_EQ(problem.variations.size(), 2u);
  const auto& uniform = std::get<UniformDraw>(problem.variations[1].distribution);
  EXPECT_EQ(uniform.lower, 0.08);
  EXPECT_EQ(uniform.upper, 0.12);
}

TEST(ProblemFromSceneTest, NormalVariationsKeepTheirTruncation) {
  Scene scene = LoadPushing();
  scene.variation[0].distribution = NormalDistribution{0.01, 0.002, 1.5};
  const Problem problem = MakeProblem(scene);
  double sum = 0.0, largest = 0.0;
  for (std::uint64_t i = 0; i < 2000; ++i) {
    const double x = SampleVariation(problem.variations, 0, RandomStream::kTestVariations, i)[0];
    sum += x;
    largest = std::max(largest, std::abs(x - 0.01));
  }
  EXPECT_LE(largest, 1.5 * 0.002 * (1.0 + 1e-12));
  EXPECT_GT(largest, 1.4 * 0.002);
  EXPECT_NEAR(sum / 2000, 0.01, 5 * 0.002 / std::sqrt(2000.0));
}

TEST(ProblemFromSceneTest, SceneWithNothingToDecideIsRefused) {
  Scene scene = LoadPushing();
  scene.design.reset();
  EXPECT_THROW(MakeProblem(scene), std::invalid_argument);
}

TEST(ProblemFromSceneTest, ControlsFollowTheDesign) {
  Scene scene = LoadPushing();
  EXPECT_EQ(MakeProblem(scene).parameters.controls, 0u);
  scene.variation.clear();  // one fixed variation
  scene.rollout.horizon = 3.0;
  scene.rollout.step = 5e-3;
  scene.controls =
      Controls{.actuators = {"hip", "knee"}, .interval = 0.1, .initial = 0.25, .lower = -2.0, .upper = 1.5};
  scene.learning.optimize = {LearnedPart::kControl};
  const Problem problem = MakeProblem(scene);
  const ParameterSpec& spec = problem.parameters;
  EXPECT_TRUE(problem.variations.empty());
  ASSERT_EQ(spec.names.size(), 7u + 60u);
  EXPECT_EQ(spec.controls, 60u);
  EXPECT_EQ(spec.names[6], "right_bow");
  EXPECT_EQ(spec.names[7], "control[0][hip]");
  EXPECT_EQ(spec.names[8], "control[0][knee]");
  EXPECT_EQ(spec.names.back(), "control[29][knee]");
  EXPECT_EQ(spec.lower.back(), -2.0);
  EXPECT_EQ(spec.upper.back(), 1.5);
  EXPECT_EQ(spec.initial.back(), 0.25);
  EXPECT_EQ(spec.GetUnit(6), "m");
  EXPECT_EQ(spec.GetUnit(7), "");
  for (std::size_t i = 0; i < spec.names.size(); ++i) EXPECT_EQ(spec.IsFixed(i), i < 7) << i;
  scene.learning.optimize = {LearnedPart::kDesign, LearnedPart::kControl};
  EXPECT_FALSE(MakeProblem(scene).parameters.IsFixed(0));
}

Scene LoadReaching() { return LoadValidScenario(KNAP_SOURCE_DIR "/configs/reaching_policy.yaml", {}).parsed.scene; }

TEST(ProblemFromSceneTest, WeightsFollowTheDesign) {
  Scene scene = LoadReaching();
  const Problem problem = MakeProblem(scene);
  const ParameterSpec& spec = problem.parameters;
  ASSERT_EQ(spec.names.size(), 9u + 220u);
  EXPECT_EQ(spec.controls, 220u);
  EXPECT_EQ(spec.names[9], "policy[0]");
  EXPECT_EQ(spec.names.back(), "policy[219]");
  EXPECT_FALSE(spec.IsFixed(0));
  EXPECT_FALSE(spec.IsFixed(9));
  // A pure function of the seed: 12 rows of 13 inputs, then biases of 0.
  EXPECT_EQ(MakeProblem(scene).parameters.initial, spec.initial);
  double sum = 0.0;
  for (int i = 0; i < 156; ++i) {
    sum += spec.initial[9 + i] * spec.initial[9 + i];
    EXPECT_LE(std::abs(spec.initial[9 + i]), 3.0 * 0.5 / std::sqrt(13.0));
  }
  EXPECT_NEAR(sum / 156 * 13, 0.25, 0.1);  // variance 0.5², which 156 draws show within a sixth or so
  for (int i = 156; i < 168; ++i) EXPECT_EQ(spec.initial[9 + i], 0.0);
  std::get<RandomWeights>(scene.policy->initial).seed = 2;
  EXPECT_NE(MakeProblem(scene).parameters.initial, spec.initial);
  scene.learning.optimize = {LearnedPart::kPolicy};
  EXPECT_TRUE(MakeProblem(scene).parameters.IsFixed(8));
  EXPECT_FALSE(MakeProblem(scene).parameters.IsFixed(9));
}

TEST(ProblemFromSceneTest, WeightsMayComeFromAFile) {
  Scene scene = LoadReaching();
  scene.policy->hidden.clear();
  scene.policy->initial = WeightsFile{"policies/w.txt"};
  EXPECT_THROW(MakeProblem(scene), std::runtime_error);
  std::string text;
  for (int i = 0; i < 56; ++i) text += fmt::format("{}\n", 0.01 * i);
  EXPECT_EQ(MakeProblem(scene, {{"policies/w.txt", text}}).parameters.initial[9 + 55], 0.01 * 55);
  EXPECT_THROW(MakeProblem(scene, {{"policies/w.txt", text + "0"}}), std::runtime_error);
}

TEST(ProblemFromSceneTest, MostRolloutsCountsEveryEvaluationOfEveryBatch) {
  LearningOptions options;
  options.variations = 12;
  options.batch = 5;
  options.max_evaluations = 10;
  // Batches of 5, 5 and 2; 5 distillation rollouts from the second on.
  EXPECT_EQ(CalcMostRollouts(options), 10 * (5 + (5 + 5) + (2 + 5)));
  options.alpha = 0.0;
  EXPECT_EQ(CalcMostRollouts(options), 10 * 12);
  options.alpha = 0.1;
  options.method = LearningMethod::kSimpleContinual;
  EXPECT_EQ(CalcMostRollouts(options), 10 * 12);
  options.method = LearningMethod::kDiffHand;
  EXPECT_EQ(CalcMostRollouts(options), 3 * 10 * 5);
}

TEST(NumberTableTest, ReadsColumnsByName) {
  EXPECT_EQ(ReadNumberTable("t.csv", "b,other,a\r\n1,x,2\r\n3.5,y,-4e-3", {"a", "b"}),
            (std::vector<std::vector<double>>{{2.0, 1.0}, {-4e-3, 3.5}}));
  const auto refusal = [](const std::string& text) {
    try {
      ReadNumberTable("t.csv", text, {"a"});
    } catch (const std::invalid_argument& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  EXPECT_EQ(refusal("b\n1\n"), "t.csv:1: no column 'a'");
  EXPECT_EQ(refusal("a\n"), "t.csv:1: no row follows the names of the columns");
  EXPECT_EQ(refusal("a\n1\n2 mm\n"), "t.csv:3: column 'a': value '2 mm': expected a number");
}

}  // namespace problem_from_scene_test
}  // namespace knap
