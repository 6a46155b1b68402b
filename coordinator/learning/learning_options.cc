#include "coordinator/learning/learning_options.h"

#include <cmath>
#include <limits>
#include <sstream>
#include <stdexcept>

#include "coordinator/optimizer/bounded_minimizer.h"
#include "coordinator/optimizer/evolution_strategy.h"

namespace knap {
namespace {

template <typename Value>
void Require(bool allowed, const char* option, const Value& value, const std::string& range) {
  if (allowed) return;
  std::ostringstream text;
  text.precision(17);
  text << option << ": " << value << " is not allowed; expected " << range;
  throw std::invalid_argument(text.str());
}

}  // namespace

const char* GetName(LearningMethod method) {
  switch (method) {
    case LearningMethod::kOurs:
      return "ours";
    case LearningMethod::kSimpleContinual:
      return "simple_continual";
    case LearningMethod::kDiffHand:
      return "diffhand";
  }
  return "";
}

LearningMethod ParseLearningMethod(const std::string& name) {
  for (const LearningMethod method :
       {LearningMethod::kOurs, LearningMethod::kSimpleContinual, LearningMethod::kDiffHand}) {
    if (name == GetName(method)) return method;
  }
  throw std::invalid_argument("method: \"" + name + "\" is not allowed; expected ours, simple_continual or diffhand");
}

int CalcBatchCount(const LearningOptions& options) {
  if (options.method == LearningMethod::kDiffHand) return 1;
  return (options.variations - 1) / options.batch + 1;
}

void CheckLearningOptions(const LearningOptions& options, std::size_t dimensions) {
  Require(options.variations >= 1, "variations", options.variations, "1 or more");
  Require(options.batch >= 1 && options.batch <= options.variations, "batch", options.batch,
          "1 to " + std::to_string(options.variations) + " (variations)");
  Require(options.dimensions_per_batch >= 1 && static_cast<std::size_t>(options.dimensions_per_batch) <= dimensions,
          "dimensions_per_batch", options.dimensions_per_batch,
          "1 to " + std::to_string(dimensions) + " (the number of parameters)");
  Require(options.validation >= 0, "validation", options.validation, "0 or more");
  Require(std::isfinite(options.alpha) && options.alpha >= 0.0, "alpha", options.alpha, "a finite value >= 0");
  Require(options.learning_rate > 0.0 && options.learning_rate <= 1.0, "learning_rate", options.learning_rate,
          "a value in (0, 1]");
  Require(options.learning_rate_decay > 0.0 && options.learning_rate_decay <= 1.0, "learning_rate_decay",
          options.learning_rate_decay, "a value in (0, 1]");
  CheckMinimizerAlgorithm(options.optimizer);
  Require(options.max_evaluations >= 2, "max_evaluations", options.max_evaluations, "2 or more");
  if (IsEvolutionStrategy(options.optimizer) && !options.rollout_budget) {
    Require(options.max_evaluations > kGeneration, "max_evaluations", options.max_evaluations,
            std::to_string(kGeneration + 1) + " or more with " + options.optimizer +
                ", the start and a generation, and better some hundred");
  }
  const std::int64_t batches = (options.variations - 1) / options.batch + 1;
  Require(options.max_evaluations * batches <= std::numeric_limits<int>::max(), "max_evaluations",
          options.max_evaluations, "fewer: over " + std::to_string(batches) + " batches they are too many to count");
  Require(std::isfinite(options.loss_tolerance) && options.loss_tolerance >= 0.0, "loss_tolerance",
          options.loss_tolerance, "a finite value >= 0");
  Require(std::isfinite(options.parameter_tolerance) && options.parameter_tolerance >= 0.0, "parameter_tolerance",
          options.parameter_tolerance, "a finite value >= 0");
  Require(options.first_step > 0.0 && options.first_step <= 1.0, "first_step", options.first_step, "a value in (0, 1]");
  if (options.rollout_budget) {
    Require(*options.rollout_budget >= 1, "rollout_budget", *options.rollout_budget, "1 or more");
  }
}

}  // namespace knap
