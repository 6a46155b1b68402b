#include "coordinator/run/problem_from_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "coordinator/run/initial_weights.h"
#include "sim/math/overloaded.h"
#include "sim/rollout/build_policy.h"
#include "sim/rollout/control_commands.h"
#include "sim/scenarios/apply_variation.h"
#include "sim/scenarios/number_table.h"

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

// `files` holds the tables.
VariationKeys MakeKeys(const Variation& variation, const std::map<std::string, std::string>& files) {
  VariationKeys keys{variation.keys, {}};
  const auto list = [](const auto& vector) { return std::vector<double>(vector.begin(), vector.end()); };
  std::visit(Overloaded{[&](const UniformDistribution& d) {
                          keys.distribution = UniformDraw{d.lower, d.upper};
                        },
                        [&](const NormalDistribution& d) {
                          keys.distribution = NormalDraw{d.mean, d.std, d.truncate_at};
                        },
                        [&](const LogUniformDistribution& d) {
                          keys.distribution = LogUniformDraw{d.lower, d.upper};
                        },
                        [&](const ChoiceDistribution& d) { keys.distribution = ChoiceDraw{d.values}; },
                        [&](const DiscDistribution& d) {
                          keys.distribution = BallDraw{list(d.center), d.radius};
                        },
                        [&](const BallDistribution& d) {
                          keys.distribution = BallDraw{list(d.center), d.radius};
                        },
                        [&](const OrientationDistribution&) { keys.distribution = OrientationDraw{}; },
                        [&](const TurnDistribution& d) {
                          keys.distribution = TurnDraw{{d.axis.x(), d.axis.y(), d.axis.z()}, d.lower, d.upper};
                        },
                        [&](const CorrelatedDistribution& d) {
                          const Eigen::MatrixXd L = MakeCorrelationMatrix(d).llt().matrixL();
                          CorrelatedDraw draw{d.mean, d.std, {}, d.truncate_at};
                          for (Eigen::Index i = 0; i < L.rows(); ++i)
                            draw.factor.push_back(list(Eigen::VectorXd(L.row(i))));
                          keys.distribution = std::move(draw);
                        },
                        [&](const TableDistribution& d) {
                          keys.distribution = RowDraw{ReadNumberTable(d.file, files.at(d.file), variation.keys)};
                        }},
             variation.distribution);
  return keys;
}

// Every row of a table must be allowed; those of other distributions were tried when the file was read.
void TryRows(const Scene& original, std::size_t first, const TableDistribution& table, const RowDraw& draw) {
  Scene scene = Scene(original);
  VariedNumbers numbers(scene);
  for (std::size_t i = 0; i < draw.rows.size(); ++i) {
    for (std::size_t k = 0; k < draw.rows[i].size(); ++k) numbers.Set(first + k, draw.rows[i][k]);
    if (const std::optional<DrawRefusal> refusal = numbers.FindRefusal()) {
      throw std::invalid_argument(fmt::format("{}:{}: {}", table.file, i + 2, refusal->message));
    }
  }
}

// As many as MakeProblem names.
std::size_t CountParameters(const Scene& scene) {
  const std::size_t design = scene.design ? scene.design->parameters.size() : 0;
  return design + static_cast<std::size_t>(CountControls(scene) + CountWeights(scene));
}

// learning.start, empty or one value a parameter.
void StartAt(const std::vector<double>& start, ParameterSpec* spec) {
  if (start.empty()) return;
  if (start.size() != spec->names.size()) {
    throw std::invalid_argument(
        fmt::format("learning.start: {} values; the scenario has {} parameters", start.size(), spec->names.size()));
  }
  for (std::size_t i = 0; i < start.size(); ++i) {
    if (start[i] >= spec->lower[i] && start[i] <= spec->upper[i]) continue;
    throw std::invalid_argument(fmt::format("learning.start[{}]: value '{:g}': {} must lie from {:g} to {:g}{}", i,
                                            start[i], spec->names[i], spec->lower[i], spec->upper[i],
                                            spec->GetUnit(i).empty() ? "" : " " + spec->GetUnit(i)));
  }
  spec->initial = start;
}

void RequireParameters(const Scene& scene) {
  if (HasParameters(scene)) return;
  throw std::invalid_argument(
      "design: the scenario has no design parameters, controls or policy: there is nothing to learn");
}

}  // namespace

bool HasParameters(const World& world) { return world.design || world.IsDriven(); }

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
  StartAt(scene.learning.start, &spec);
  std::size_t numbers = 0;
  for (const Variation& variation : scene.variation) {
    problem.variations.push_back(MakeKeys(variation, files));
    if (const auto* table = std::get_if<TableDistribution>(&variation.distribution)) {
      TryRows(scene, numbers, *table, std::get<RowDraw>(problem.variations.back().distribution));
    }
    numbers += variation.keys.size();
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
  options.loss_tolerance = learning.loss_tolerance;
  options.parameter_tolerance = learning.parameter_tolerance;
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
