#include "coordinator/cli/problem_from_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <string>
#include <variant>
#include <vector>

#include "coordinator/cli/initial_weights.h"
#include "sim/rollout/build_policy.h"
#include "sim/rollout/control_commands.h"

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

// As many as MakeProblem names.
std::size_t CountParameters(const Scene& scene) {
  const std::size_t design = scene.design ? scene.design->parameters.size() : 0;
  return design + static_cast<std::size_t>(CountControls(scene) + CountWeights(scene));
}

void RequireParameters(const Scene& scene) {
  if (HasParameters(scene)) return;
  throw std::invalid_argument(
      "design: the scenario has no design parameters, controls or policy: there is nothing to learn");
}

}  // namespace

bool HasParameters(const Scene& scene) { return scene.design || scene.IsDriven(); }

Problem MakeProblem(const Scene& scene, const std::map<std::string, std::string>& files) {
  RequireParameters(scene);
  const auto is_fixed = [&](LearnedPart part) {
    const std::vector<LearnedPart>& moving = scene.learning.optimize;
    return std::find(moving.begin(), moving.end(), part) == moving.end();
  };
  Problem problem;
  ParameterSpec& spec = problem.parameters;
  const auto add = [&spec](const std::string& name, double lower, double upper, double initial, bool fixed) {
    spec.names.push_back(name);
    spec.lower.push_back(lower);
    spec.upper.push_back(upper);
    spec.initial.push_back(initial);
    spec.fixed.push_back(fixed);
  };
  if (scene.design) {
    for (const DesignParameter& parameter : scene.design->parameters) {
      add(parameter.name, parameter.lower, parameter.upper, parameter.initial, is_fixed(LearnedPart::kDesign));
      spec.units.push_back(parameter.kind == ParameterKind::kShift ? "m" : "");
    }
  }
  if (scene.controls) {
    const Controls& controls = *scene.controls;
    for (int i = 0; i < CountIntervals(controls.interval, scene.rollout); ++i) {
      for (const std::string& actuator : controls.actuators) {
        add(fmt::format("control[{}][{}]", i, actuator), controls.lower, controls.upper, controls.initial,
            is_fixed(LearnedPart::kControl));
        spec.units.push_back("");
        ++spec.controls;
      }
    }
  }
  if (scene.policy) {
    const std::vector<double> weights = MakeInitialWeights(*scene.policy, files);
    for (std::size_t i = 0; i < weights.size(); ++i) {
      add(fmt::format("policy[{}]", i), scene.policy->lower, scene.policy->upper, weights[i],
          is_fixed(LearnedPart::kPolicy));
      spec.units.push_back("");
      ++spec.controls;
    }
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
  // It counts design parameters; a scene without any has no use for it.
  if (!scene.design) options.dimensions_per_batch = 1;
  options.alpha = learning.alpha;
  options.learning_rate = learning.learning_rate;
  options.learning_rate_decay = learning.decay;
  options.optimizer = learning.optimizer;
  options.max_evaluations = static_cast<int>(learning.max_evaluations);
  if (learning.rollout_budget > 0) options.rollout_budget = learning.rollout_budget;
  options.validation = static_cast<int>(learning.validation);
  options.keep_best = learning.keep == Keep::kBest;
  options.seed = static_cast<std::uint64_t>(learning.seed);
  RequireParameters(scene);
  CheckLearningOptions(options, CountParameters(scene));
  return options;
}

std::int64_t CalcMostRollouts(const LearningOptions& options) {
  const std::int64_t n = options.variations, m = options.batch, evaluations = options.max_evaluations;
  const std::int64_t validations = static_cast<std::int64_t>(options.validation) * (1 + CalcBatchCount(options));
  if (options.rollout_budget) return validations + *options.rollout_budget;
  const std::int64_t batches = (n - 1) / m + 1;
  if (options.method == LearningMethod::kDiffHand) return validations + evaluations * batches * m;
  const bool distils = options.method == LearningMethod::kOurs && options.alpha > 0.0;
  return validations + evaluations * (n + (distils ? (batches - 1) * m : 0));
}

}  // namespace knap
