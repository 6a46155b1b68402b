#include "coordinator/cli/problem_from_scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <variant>

#include "coordinator/cli/loaded_run.h"

namespace knap {
namespace {

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

TEST(ProblemFromSceneTest, SceneWithoutDesignOrVariationIsRefused) {
  Scene scene = LoadPushing();
  scene.variation.clear();
  EXPECT_THROW(MakeProblem(scene), std::invalid_argument);
  scene = LoadPushing();
  scene.design.reset();
  EXPECT_THROW(MakeProblem(scene), std::invalid_argument);
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

}  // namespace
}  // namespace knap
