#include "coordinator/learning/schedule.h"

#include <algorithm>
#include <limits>
#include <span>
#include <utility>

#include "coordinator/learning/dimension_selection.h"
#include "coordinator/optimizer/bounded_minimizer.h"
#include "coordinator/random/counter_random.h"

namespace knap {
namespace {

BatchStop MakeBatchStop(MinimizerStop stop) {
  switch (stop) {
    case MinimizerStop::kConverged:
      return BatchStop::kConverged;
    case MinimizerStop::kEvaluations:
      return BatchStop::kEvaluations;
    case MinimizerStop::kStalled:
      return BatchStop::kStalled;
  }
  return BatchStop::kStalled;
}

class Schedule {
 public:
  Schedule(const Problem& problem, const LearningOptions& options, RolloutService& service, LearningObserver& observer)
      : parameters_(problem.parameters),
        variations_(problem.variations),
        options_(options),
        service_(service),
        observer_(observer),
        selection_(parameters_.names.size(), static_cast<std::size_t>(options.dimensions_per_batch),
                   options.learning_rate, options.learning_rate_decay) {
    for (std::size_t i = 0; i < parameters_.names.size(); ++i) {
      range_.push_back(parameters_.upper[i] - parameters_.lower[i]);
    }
    result_.theta = parameters_.initial;
  }

  LearningResult Run() {
    const int batches = CalcBatchCount(options_);
    Validate(0);
    for (int t = 1; t <= batches; ++t) {
      BatchStart start{.batch = t, .batches = batches, .theta = result_.theta};
      start.variations = MakeBatch(t);
      start.distillation = DrawDistillationSet(t);
      start.max_evaluations = CalcEvaluationLimit(start);
      if (start.max_evaluations == 0) {
        result_.budget_exhausted = true;
        break;
      }
      RunBatch(start);
      Validate(t);
    }
    if (options_.validation > 0 && options_.keep_best) {
      result_.theta = best_theta_;
    } else {
      result_.batch = result_.batches.empty() ? 0 : result_.batches.back().batch;
    }
    result_.restarts = selection_.restarts();
    return std::move(result_);
  }

 private:
  // theta_t, which is result_.theta now.
  void Validate(int t) {
    if (options_.validation == 0) return;
    observer_.OnValidationStart();
    BatchValidation validation{.batch = t};
    validation.test = EvaluateDesign(variations_, result_.theta, options_.validation, options_.seed, service_,
                                     RandomStream::kValidation)
                          .summary;
    validation.is_best = t == 0 || IsBetter(validation.test, best_test_);
    if (validation.is_best) {
      best_test_ = validation.test;
      best_theta_ = result_.theta;
      result_.batch = t;
    }
    result_.validations.push_back(validation);
    observer_.OnValidation(validation);
  }

  // Batch t holds the training variations (t-1) M … min(t M, N) - 1.
  std::vector<std::uint64_t> MakeBatch(int t) const {
    const auto m = static_cast<std::uint64_t>(options_.batch);
    const std::uint64_t first = static_cast<std::uint64_t>(t - 1) * m;
    const std::uint64_t end = std::min(first + m, static_cast<std::uint64_t>(options_.variations));
    std::vector<std::uint64_t> indices;
    for (std::uint64_t i = first; i < end; ++i) indices.push_back(i);
    return indices;
  }

  // Drawn without replacement from batches 1 … t-1; sorted, so that the reduction runs by variation index.
  std::vector<std::uint64_t> DrawDistillationSet(int t) const {
    if (options_.method != LearningMethod::kOurs || options_.alpha == 0.0 || t == 1) return {};
    const auto m = static_cast<std::uint64_t>(options_.batch);
    CounterRandom random(options_.seed, RandomStream::kDistillation, static_cast<std::uint64_t>(t));
    std::vector<std::uint64_t> indices = random.DrawWithoutReplacement(static_cast<std::uint64_t>(t - 1) * m, m);
    std::sort(indices.begin(), indices.end());
    return indices;
  }

  std::vector<std::vector<double>> SampleVariations(const std::vector<std::uint64_t>& indices,
                                                    RandomStream stream) const {
    std::vector<std::vector<double>> values;
    for (const std::uint64_t index : indices) {
      values.push_back(SampleVariation(variations_, options_.seed, stream, index));
    }
    return values;
  }

  // 0: the budget does not pay for a start and one more evaluation.
  int CalcEvaluationLimit(const BatchStart& start) const {
    if (!options_.rollout_budget) {
      const int batches = (options_.variations - 1) / options_.batch + 1;
      return options_.max_evaluations * (options_.method == LearningMethod::kDiffHand ? batches : 1);
    }
    const auto cost = static_cast<std::int64_t>(start.variations.size() + start.distillation.size());
    const std::int64_t left = *options_.rollout_budget - result_.rollouts;
    if (left < 2 * cost) return 0;
    const std::int64_t share = left / (start.batches - start.batch + 1) / cost;
    return static_cast<int>(std::clamp<std::int64_t>(share, 2, std::numeric_limits<int>::max()));
  }

  void RunBatch(const BatchStart& start) {
    observer_.OnBatchStart(start);
    const RandomStream stream =
        options_.method == LearningMethod::kDiffHand ? RandomStream::kFirstBatch : RandomStream::kTrainingVariations;
    BatchObjective objective(SampleVariations(start.variations, stream),
                             SampleVariations(start.distillation, RandomStream::kTrainingVariations), start.theta,
                             range_, options_.alpha, service_);
    BatchEnd end{.batch = start.batch, .theta = start.theta, .best_loss = std::numeric_limits<double>::infinity()};
    const BatchEvaluation first = objective.EvaluateStart();
    Record(first, end);
    end.start_loss = first.loss;
    const BatchBox box = MakeBox(start, first, objective);
    result_.excluded += objective.excluded_task() + objective.excluded_distillation();
    observer_.OnBatchBox(box);
    if (!first.accepted) {
      end.stop = BatchStop::kNothingTrusted;
    } else if (box.dimensions.empty()) {
      end.stop = BatchStop::kFlat;
    } else {
      MinimizeBatch(start, box, first, objective, end);
    }
    result_.theta = end.theta;
    result_.batches.push_back(end);
    observer_.OnBatchEnd(end);
  }

  BatchBox MakeBox(const BatchStart& start, const BatchEvaluation& first, const BatchObjective& objective) {
    BatchBox box{.batch = start.batch, .lower = start.theta, .upper = start.theta};
    box.excluded_task = objective.excluded_task();
    box.excluded_distillation = objective.excluded_distillation();
    box.radius = options_.method == LearningMethod::kOurs ? selection_.learning_rate() : 1.0;
    if (!first.accepted) return box;

    const std::size_t d = start.theta.size();
    std::vector<double> normalised_gradient(d);
    // What is fixed counts as flat: neither chosen nor marked as used.
    for (std::size_t i = 0; i < d; ++i) {
      normalised_gradient[i] = parameters_.IsFixed(i) ? 0.0 : first.gradient[i] * range_[i];
    }
    if (options_.method == LearningMethod::kOurs) {
      DimensionChoice choice = selection_.Choose(normalised_gradient);
      box.dimensions = std::move(choice.dimensions);
      box.radius = choice.learning_rate;
      box.restarted = choice.restarted;
    } else if (std::any_of(normalised_gradient.begin(), normalised_gradient.end(), [](double g) { return g != 0.0; })) {
      for (std::size_t i = 0; i < d; ++i) {
        if (!parameters_.IsFixed(i)) box.dimensions.push_back(i);
      }
    }
    for (const std::size_t i : box.dimensions) {
      box.lower[i] = parameters_.lower[i];
      box.upper[i] = parameters_.upper[i];
      if (options_.method == LearningMethod::kOurs) {
        box.lower[i] = std::max(box.lower[i], start.theta[i] - box.radius * range_[i]);
        box.upper[i] = std::min(box.upper[i], start.theta[i] + box.radius * range_[i]);
      }
    }
    return box;
  }

  void MinimizeBatch(const BatchStart& start, const BatchBox& box, const BatchEvaluation& first,
                     BatchObjective& objective, BatchEnd& end) {
    MinimizerProblem problem;
    for (const std::size_t i : box.dimensions) {
      problem.lower.push_back(box.lower[i]);
      problem.upper.push_back(box.upper[i]);
      problem.scale.push_back(range_[i]);
      problem.start.push_back(start.theta[i]);
    }
    problem.start_value = MakeObjectiveValue(first, box);
    const MinimizerOptions minimizer_options{
        .algorithm = options_.optimizer,
        .max_evaluations = start.max_evaluations,
        .value_tolerance = options_.loss_tolerance,
        .step_tolerance = options_.parameter_tolerance,
        .first_step = options_.first_step,
        .seed =
            CounterRandom(options_.seed, RandomStream::kOptimizer, static_cast<std::uint64_t>(start.batch)).DrawBits()};
    const bool with_gradient = UsesGradient(options_.optimizer);
    const Objective evaluate = [&](std::span<const std::vector<double>> points) {
      std::vector<std::vector<double>> thetas;
      for (const std::vector<double>& x : points) thetas.push_back(InsertCoordinates(start.theta, box, x));
      std::vector<ObjectiveValue> values;
      for (const BatchEvaluation& evaluation : objective.Evaluate(thetas, with_gradient)) {
        Record(evaluation, end);
        values.push_back(MakeObjectiveValue(evaluation, box));
      }
      return values;
    };
    const MinimizerResult minimum = Minimize(evaluate, problem, minimizer_options);
    end.theta = InsertCoordinates(start.theta, box, minimum.x);
    end.stop = MakeBatchStop(minimum.stop);
  }

  static std::vector<double> InsertCoordinates(std::vector<double> theta, const BatchBox& box,
                                               const std::vector<double>& x) {
    for (std::size_t k = 0; k < x.size(); ++k) theta[box.dimensions[k]] = x[k];
    return theta;
  }

  static ObjectiveValue MakeObjectiveValue(const BatchEvaluation& evaluation, const BatchBox& box) {
    ObjectiveValue value{.accepted = evaluation.accepted, .value = evaluation.loss};
    if (!evaluation.gradient.empty()) {
      for (const std::size_t i : box.dimensions) value.gradient.push_back(evaluation.gradient[i]);
    }
    return value;
  }

  void Record(const BatchEvaluation& evaluation, BatchEnd& end) {
    result_.rollouts += evaluation.rollouts;
    result_.untrusted += evaluation.untrusted;
    result_.doubtful_gradients += evaluation.doubtful_gradients;
    ++result_.evaluations;
    if (evaluation.accepted) {
      end.best_loss = std::min(end.best_loss, evaluation.loss);
    } else {
      ++end.rejected;
      ++result_.rejected;
    }
    observer_.OnEvaluation({.batch = end.batch,
                            .evaluation = end.evaluations++,
                            .value = evaluation,
                            .best_loss = end.best_loss,
                            .rollouts = result_.rollouts});
  }

  const ParameterSpec& parameters_;
  const VariationSpec& variations_;
  const LearningOptions& options_;
  RolloutService& service_;
  LearningObserver& observer_;
  DimensionSelection selection_;
  std::vector<double> range_;
  LearningResult result_;
  TestSummary best_test_;  // of the validations
  std::vector<double> best_theta_;
};

}  // namespace

const char* GetName(BatchStop stop) {
  switch (stop) {
    case BatchStop::kConverged:
      return "converged";
    case BatchStop::kEvaluations:
      return "evaluations";
    case BatchStop::kStalled:
      return "stalled";
    case BatchStop::kFlat:
      return "flat";
    case BatchStop::kNothingTrusted:
      return "nothing_trusted";
  }
  return "";
}

LearningResult Learn(const Problem& problem, const LearningOptions& options, RolloutService& service,
                     LearningObserver& observer) {
  CheckProblem(problem);
  CheckLearningOptions(options, problem.parameters.names.size());
  return Schedule(problem, options, service, observer).Run();
}

}  // namespace knap
