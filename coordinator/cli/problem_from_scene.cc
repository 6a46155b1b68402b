#include "coordinator/cli/problem_from_scene.h"

#include <algorithm>
#include <stdexcept>
#include <variant>

namespace knap {
namespace {

LearningMethod MakeMethod(SceneLearningMethod method) {
  switch (method) {
    case SceneLearningMethod::kOurs:
      return LearningMethod::kOurs;
    case SceneLearningMethod::kSimpleContinual:
      return LearningMethod::kSimpleContinual;
    case SceneLearningMethod::kDiffHand:
      return LearningMethod::kDiffHand;
  }
  return LearningMethod::kOurs;
}

UniformDraw MakeDraw(const UniformDistribution& uniform) { return {uniform.lower, uniform.upper}; }

NormalDraw MakeDraw(const NormalDistribution& normal) { return {normal.mean, normal.std, normal.truncate_at}; }

}  // namespace

Problem MakeProblem(const Scene& scene) {
  if (!scene.design || scene.design->parameters.empty()) {
    throw std::invalid_argument("design: the scenario has no design parameters, so there is nothing to learn");
  }
  Problem problem;
  for (const DesignParameter& parameter : scene.design->parameters) {
    problem.parameters.names.push_back(parameter.name);
    problem.parameters.lower.push_back(parameter.lower);
    problem.parameters.upper.push_back(parameter.upper);
    problem.parameters.initial.push_back(parameter.initial);
  }
  for (const Variation& variation : scene.variation) {
    VariationKey key;
    key.name = variation.key;
    std::visit([&key](const auto& distribution) { key.distribution = MakeDraw(distribution); }, variation.distribution);
    problem.variations.push_back(key);
  }
  CheckProblem(problem);
  return problem;
}

LearningOptions MakeLearningOptions(const Scene& scene) {
  const Learning& learning = scene.learning;
  LearningOptions options;
  options.method = MakeMethod(learning.method);
  options.variations = static_cast<int>(learning.variations);
  options.batch = static_cast<int>(learning.batch);
  options.dimensions_per_batch = static_cast<int>(learning.dimensions_per_batch);
  options.alpha = learning.alpha;
  options.learning_rate = learning.learning_rate;
  options.learning_rate_decay = learning.decay;
  options.optimizer = learning.optimizer;
  options.max_evaluations = static_cast<int>(learning.max_evaluations);
  if (learning.rollout_budget > 0) options.rollout_budget = learning.rollout_budget;
  options.seed = static_cast<std::uint64_t>(learning.seed);
  CheckLearningOptions(options, scene.design ? scene.design->parameters.size() : 0);
  return options;
}

std::int64_t CalcMostRollouts(const LearningOptions& options) {
  const std::int64_t n = options.variations, m = options.batch, evaluations = options.max_evaluations;
  if (options.rollout_budget) return *options.rollout_budget;
  const std::int64_t batches = (n - 1) / m + 1;
  if (options.method == LearningMethod::kDiffHand) return evaluations * batches * m;
  const bool distils = options.method == LearningMethod::kOurs && options.alpha > 0.0;
  return evaluations * (n + (distils ? (batches - 1) * m : 0));
}

}  // namespace knap
