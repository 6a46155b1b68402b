#include "coordinator/learning/schedule.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <stdexcept>

#include "tests/coordinator/closed_form_service.h"
#include "tests/coordinator/schedule_fixture.h"

namespace knap {
namespace schedule_test {

TEST(ScheduleTest, EveryMethodFindsTheKnownOptimum) {
  for (const LearningMethod method :
       {LearningMethod::kOurs, LearningMethod::kSimpleContinual, LearningMethod::kDiffHand}) {
    SCOPED_TRACE(GetName(method));
    QuadraticService service(kWeights, kOptimum);
    Recorder recorder;
    const LearningResult result = Learn(MakeProblem(), MakeOptions(method), service, recorder);
    // A batch's own minimum differs from the optimum by the mean of five uniform draws of ±0.02, in each of seven
    // dimensions: standard deviation 0.02/sqrt(15) · sqrt(7) = 0.014 in all.
    EXPECT_LT(CalcDistance(result.theta, kOptimum), 0.04);
    EXPECT_GT(CalcDistance(MakeProblem().parameters.initial, kOptimum), 0.4);
    EXPECT_EQ(result.untrusted, 0);
    EXPECT_FALSE(result.budget_exhausted);
  }
}

TEST(ScheduleTest, BatchesCoverTheVariationsInOrder) {
  LearningOptions options = MakeOptions();
  options.variations = 13;
  QuadraticService service(kWeights, kOptimum);
  Recorder recorder;
  Learn(MakeProblem(), options, service, recorder);
  ASSERT_EQ(recorder.starts.size(), 3u);
  EXPECT_EQ(recorder.starts[0].variations, (std::vector<std::uint64_t>{0, 1, 2, 3, 4}));
  EXPECT_EQ(recorder.starts[2].variations, (std::vector<std::uint64_t>{10, 11, 12}));  // the last one is short
  EXPECT_EQ(recorder.starts[2].distillation.size(), 5u);
  EXPECT_EQ(recorder.starts[2].batches, 3);
  EXPECT_EQ(service.calls[0][3].variation,
            SampleVariation(MakeProblem().variations, 0, RandomStream::kTrainingVariations, 3));
}

TEST(ScheduleTest, DistillationSetIsDrawnFromEarlierBatchesAndFixedDuringOne) {
  const Problem problem = MakeProblem();
  QuadraticService service(kWeights, kOptimum);
  Recorder recorder;
  Learn(problem, MakeOptions(), service, recorder);
  ASSERT_EQ(recorder.starts.size(), 20u);
  EXPECT_TRUE(recorder.starts[0].distillation.empty());
  std::set<std::uint64_t> drawn;
  for (std::size_t t = 1; t < recorder.starts.size(); ++t) {
    const std::vector<std::uint64_t>& d = recorder.starts[t].distillation;
    EXPECT_EQ(d.size(), 5u);
    EXPECT_EQ(std::set<std::uint64_t>(d.begin(), d.end()).size(), 5u);  // without replacement
    EXPECT_TRUE(std::is_sorted(d.begin(), d.end()));                    // the order of the reduction
    for (const std::uint64_t index : d) EXPECT_LT(index, recorder.starts[t].variations.front());
    drawn.insert(d.begin(), d.end());
  }
  EXPECT_GT(drawn.size(), 30u);  // not always the same few

  // Every evaluation of a batch asks for exactly this set, against theta_{t-1}, after the batch's own variations.
  std::size_t call = 0;
  for (std::size_t t = 0; t < recorder.starts.size(); ++t) {
    const BatchStart& start = recorder.starts[t];
    for (int evaluation = 0; evaluation < recorder.ends[t].evaluations; ++evaluation, ++call) {
      const std::vector<RolloutQuery>& queries = service.calls[call];
      ASSERT_EQ(queries.size(), start.variations.size() + start.distillation.size());
      for (std::size_t k = 0; k < queries.size(); ++k) {
        const bool task = k < start.variations.size();
        const std::uint64_t index = task ? start.variations[k] : start.distillation[k - start.variations.size()];
        EXPECT_EQ(queries[k].variation,
                  SampleVariation(problem.variations, 0, RandomStream::kTrainingVariations, index));
        EXPECT_EQ(queries[k].theta_reference, task ? std::vector<double>{} : start.theta);
      }
    }
  }
  EXPECT_EQ(call, service.calls.size());
}

TEST(ScheduleTest, OnlyTheChosenDimensionsMoveAndStayInTheBox) {
  const Problem problem = MakeProblem(0.15);  // noisy batches pull hard
  QuadraticService service(kWeights, kOptimum);
  Recorder recorder;
  Learn(problem, MakeOptions(), service, recorder);
  std::set<std::size_t> used;
  double rate = 0.25;
  for (std::size_t t = 0; t < recorder.boxes.size(); ++t) {
    const BatchBox& box = recorder.boxes[t];
    EXPECT_GE(box.dimensions.size(), 1u);
    EXPECT_LE(box.dimensions.size(), 2u);
    if (used.size() == kDimensions) {
      used.clear();
      rate *= std::exp(-1.0);
      EXPECT_TRUE(box.restarted);
    }
    for (const std::size_t i : box.dimensions) EXPECT_TRUE(used.insert(i).second) << "used twice in batch " << t + 1;
    EXPECT_NEAR(box.radius, rate, 1e-15);
    for (const LearningEvaluation& evaluation : recorder.evaluations) {
      if (evaluation.batch != box.batch) continue;
      for (std::size_t i = 0; i < kDimensions; ++i) {
        const double theta = evaluation.value.theta[i], before = recorder.starts[t].theta[i];
        const double range = problem.parameters.upper[i] - problem.parameters.lower[i];
        if (std::find(box.dimensions.begin(), box.dimensions.end(), i) == box.dimensions.end()) {
          EXPECT_EQ(theta, before);
        }
        EXPECT_LE(std::abs(theta - before), rate * range * (1.0 + 1e-12));
        EXPECT_GE(theta, problem.parameters.lower[i]);
        EXPECT_LE(theta, problem.parameters.upper[i]);
      }
    }
  }
  EXPECT_EQ(recorder.boxes.size(), 20u);  // seven dimensions, two a batch: four batches a round, four restarts
  EXPECT_NEAR(rate, 0.25 * std::exp(-4.0), 1e-15);
}

TEST(ScheduleTest, ChosenDimensionsAreTheSteepestInNormalisedParameters) {
  // Raw slopes 2 w_i e_i favour dimension 1; over its range of 0.01 it matters least.
  Problem problem = MakeProblem(0.0);
  problem.parameters.lower[1] = 0.395;
  problem.parameters.upper[1] = 0.405;
  std::vector<double> weights = kWeights;
  weights[1] = 40.0;
  QuadraticService service(weights, kOptimum);
  Recorder recorder;
  LearningOptions options = MakeOptions();
  options.variations = 5;
  Learn(problem, options, service, recorder);
  // |2 w e range|: 0.4, 0.08, 0.6, 0.04, 1.8, 0.12, 0.5 for errors e = 0.4 - c.
  EXPECT_EQ(recorder.boxes[0].dimensions, (std::vector<std::size_t>{4, 2}));
}

TEST(ScheduleTest, LossIsTaskPlusAlphaDistillation) {
  QuadraticService service(kWeights, kOptimum);
  Recorder recorder;
  LearningOptions options = MakeOptions();
  options.alpha = 0.7;
  Learn(MakeProblem(0.1), options, service, recorder);
  int moved = 0;
  for (const LearningEvaluation& evaluation : recorder.evaluations) {
    const BatchEvaluation& value = evaluation.value;
    EXPECT_DOUBLE_EQ(value.loss, value.task_loss + 0.7 * value.distillation_loss);
    const BatchStart& start = recorder.starts[static_cast<std::size_t>(evaluation.batch - 1)];
    const double distance = CalcDistance(value.theta, start.theta);
    if (evaluation.batch == 1) {
      EXPECT_EQ(value.distillation_loss, 0.0);
    } else {
      EXPECT_NEAR(value.distillation_loss, distance * distance, 1e-14);
      moved += distance > 0.0 ? 1 : 0;
    }
  }
  EXPECT_GT(moved, 20);
}

TEST(ScheduleTest, GradientIsTheDerivativeOfTheLoss) {
  QuadraticService service(kWeights, kOptimum);
  const std::vector<double> reference(kDimensions, 0.4), range(kDimensions, 1.0);
  std::vector<std::vector<double>> task, distillation;
  for (std::uint64_t i = 0; i < 5; ++i) {
    task.push_back(SampleVariation(MakeProblem().variations, 0, RandomStream::kTrainingVariations, i));
    distillation.push_back(SampleVariation(MakeProblem().variations, 0, RandomStream::kTrainingVariations, 10 + i));
  }
  BatchObjective objective(task, distillation, reference, range, 0.3, service);
  objective.EvaluateStart();
  std::vector<double> theta = {0.5, 0.2, 0.3, 0.45, 0.6, 0.4, 0.1};
  const BatchEvaluation at = objective.Evaluate({&theta, 1}, true).front();
  double norm_squared = 0.0;
  for (std::size_t i = 0; i < kDimensions; ++i) {
    constexpr double kStep = 1e-4;  // central differences of a quadratic are exact but for rounding, 1e-16 / 1e-4
    std::vector<double> up = theta, down = theta;
    up[i] += kStep;
    down[i] -= kStep;
    const double slope =
        (objective.Evaluate({&up, 1}, false).front().loss - objective.Evaluate({&down, 1}, false).front().loss) /
        (2 * kStep);
    EXPECT_NEAR(at.gradient[i], slope, 1e-10);
    norm_squared += at.gradient[i] * at.gradient[i];
  }
  EXPECT_NEAR(at.gradient_norm, std::sqrt(norm_squared), 1e-14);
}

TEST(ScheduleTest, BaselinesMoveEverythingInTheFullBounds) {
  for (const LearningMethod method : {LearningMethod::kSimpleContinual, LearningMethod::kDiffHand}) {
    const Problem problem = MakeProblem();
    QuadraticService service(kWeights, kOptimum);
    Recorder recorder;
    Learn(problem, MakeOptions(method), service, recorder);
    EXPECT_EQ(recorder.boxes.size(), method == LearningMethod::kDiffHand ? 1u : 20u);
    for (const BatchBox& box : recorder.boxes) {
      EXPECT_EQ(box.dimensions.size(), kDimensions);
      EXPECT_EQ(box.lower, problem.parameters.lower);
      EXPECT_EQ(box.upper, problem.parameters.upper);
    }
    for (const auto& queries : service.calls) {
      EXPECT_EQ(queries.size(), 5u);
      for (const RolloutQuery& query : queries) EXPECT_TRUE(query.theta_reference.empty());
    }
  }
}

TEST(ScheduleTest, DiffHandDrawsABatchOfItsOwn) {
  const Problem problem = MakeProblem();
  QuadraticService service(kWeights, kOptimum);
  Recorder recorder;
  Learn(problem, MakeOptions(LearningMethod::kDiffHand), service, recorder);
  for (std::size_t k = 0; k < 5; ++k) {
    EXPECT_EQ(service.calls[0][k].variation, SampleVariation(problem.variations, 0, RandomStream::kFirstBatch, k));
  }
}

TEST(ScheduleTest, TheSameAnswersGiveTheSameBits) {
  for (const LearningMethod method :
       {LearningMethod::kOurs, LearningMethod::kSimpleContinual, LearningMethod::kDiffHand}) {
    std::vector<LearningResult> results;
    for (int run = 0; run < 2; ++run) {
      QuadraticService service(kWeights, kOptimum);
      Recorder recorder;
      results.push_back(Learn(MakeProblem(0.1), MakeOptions(method), service, recorder));
    }
    EXPECT_EQ(results[0].theta, results[1].theta);
    EXPECT_EQ(results[0].rollouts, results[1].rollouts);
  }
  QuadraticService service(kWeights, kOptimum);
  Recorder recorder;
  LearningOptions options = MakeOptions();
  options.seed = 1;
  const std::vector<double> other = Learn(MakeProblem(0.1), options, service, recorder).theta;
  options.seed = 0;
  EXPECT_NE(other, Learn(MakeProblem(0.1), options, service, recorder).theta);
}

TEST(ScheduleTest, BestLossNeverRisesAndEndsAtTheBestPoint) {
  QuadraticService service(kWeights, kOptimum);
  Recorder recorder;
  const LearningResult result = Learn(MakeProblem(0.1), MakeOptions(), service, recorder);
  std::int64_t rollouts = 0;
  for (const LearningEvaluation& evaluation : recorder.evaluations) {
    rollouts += evaluation.value.rollouts;
    EXPECT_EQ(evaluation.rollouts, rollouts);
    EXPECT_LE(evaluation.best_loss, evaluation.value.loss);
  }
  EXPECT_EQ(result.rollouts, rollouts);
  for (std::size_t t = 0; t < recorder.ends.size(); ++t) {
    const BatchEnd& end = recorder.ends[t];
    EXPECT_LE(end.best_loss, end.start_loss);
    EXPECT_LE(end.evaluations, 20);
    double best = std::numeric_limits<double>::infinity();
    std::vector<double> theta;
    for (const LearningEvaluation& evaluation : recorder.evaluations) {
      if (evaluation.batch == end.batch && evaluation.value.loss < best) {
        best = evaluation.value.loss;
        theta = evaluation.value.theta;
      }
    }
    EXPECT_EQ(end.theta, theta);
    EXPECT_EQ(end.best_loss, best);
    if (t + 1 < recorder.starts.size()) {
      EXPECT_EQ(recorder.starts[t + 1].theta, end.theta);
    }
  }
  EXPECT_EQ(result.theta, recorder.ends.back().theta);
}

// One batch whose variations all pull to a far corner: the box and the distillation keep what was learned before.
TEST(ScheduleTest, ABudgetIsSharedAndNeverExceeded) {
  for (const LearningMethod method :
       {LearningMethod::kOurs, LearningMethod::kSimpleContinual, LearningMethod::kDiffHand}) {
    for (const std::int64_t budget : {1, 9, 10, 57, 400, 1234}) {
      LearningOptions options = MakeOptions(method);
      options.rollout_budget = budget;
      options.loss_tolerance = options.parameter_tolerance = 0.0;
      QuadraticService service(kWeights, kOptimum);
      Recorder recorder;
      const LearningResult result = Learn(MakeProblem(0.1), options, service, recorder);
      EXPECT_LE(result.rollouts, budget);
      EXPECT_EQ(result.budget_exhausted, recorder.ends.size() < (method == LearningMethod::kDiffHand ? 1u : 20u));
      if (budget == 1234) {
        EXPECT_FALSE(result.budget_exhausted);
      }
    }
  }
}

TEST(ScheduleTest, DiffHandMayUseAsManyEvaluationsAsTheContinualMethods) {
  QuadraticService service(kWeights, kOptimum);
  Recorder recorder;
  Learn(MakeProblem(), MakeOptions(LearningMethod::kDiffHand), service, recorder);
  EXPECT_EQ(recorder.starts[0].max_evaluations, 20 * 20);
}

TEST(ScheduleTest, AnAlgorithmWithoutGradientsAsksForThemOnlyToChoose) {
  LearningOptions options = MakeOptions();
  options.optimizer = "LN_BOBYQA";
  QuadraticService service(kWeights, kOptimum);
  Recorder recorder;
  const LearningResult result = Learn(MakeProblem(), options, service, recorder);
  EXPECT_LT(CalcDistance(result.theta, kOptimum), 0.06);
  std::size_t call = 0;
  for (const BatchEnd& end : recorder.ends) {
    for (int evaluation = 0; evaluation < end.evaluations; ++evaluation, ++call) {
      EXPECT_EQ(service.calls[call][0].gradient, evaluation == 0);
    }
  }
}

// A generation's rollouts are asked for in one call, so that many workers are busy at a time.
TEST(ScheduleTest, AnEvolutionStrategyAsksForAGenerationAtOnce) {
  for (const char* optimizer : {"CMA_ES", "CMA_ES_GRADIENT"}) {
    LearningOptions options = MakeOptions(LearningMethod::kDiffHand);
    options.variations = options.batch = 5;
    options.optimizer = optimizer;
    options.max_evaluations = 401;
    options.loss_tolerance = options.parameter_tolerance = 0.0;
    const auto learn = [&](QuadraticService* service) {
      Recorder recorder;
      const LearningResult result = Learn(MakeProblem(), options, *service, recorder);
      EXPECT_EQ(recorder.evaluations.size(), 401u);
      return result.theta;
    };
    QuadraticService service(kWeights, kOptimum);
    const std::vector<double> theta = learn(&service);
    EXPECT_LT(CalcDistance(theta, kOptimum), 0.05) << optimizer;
    ASSERT_EQ(service.calls.size(), 1u + 25u);
    for (std::size_t i = 1; i < service.calls.size(); ++i) EXPECT_EQ(service.calls[i].size(), 16u * 5u);
    QuadraticService again(kWeights, kOptimum);
    EXPECT_EQ(learn(&again), theta);
    options.max_evaluations = 16;
    QuadraticService none(kWeights, kOptimum);
    Recorder recorder;
    EXPECT_THROW(Learn(MakeProblem(), options, none, recorder), std::invalid_argument);
  }
}

TEST(ScheduleTest, BadProblemsAndOptionsAreNamed) {
  const auto message_of = [](const Problem& problem, const LearningOptions& options) -> std::string {
    QuadraticService service(kWeights, kOptimum);
    Recorder recorder;
    try {
      Learn(problem, options, service, recorder);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  Problem problem = MakeProblem();
  problem.parameters.initial[2] = 1.5;
  EXPECT_NE(message_of(problem, MakeOptions()).find("p2: initial value 1.5"), std::string::npos);
  problem = MakeProblem();
  problem.variations[1].names[0] = "v0";
  EXPECT_NE(message_of(problem, MakeOptions()).find("\"v0\" occurs twice"), std::string::npos);
  LearningOptions options = MakeOptions();
  options.batch = 101;
  EXPECT_NE(message_of(MakeProblem(), options).find("batch: 101"), std::string::npos);
  options = MakeOptions();
  options.dimensions_per_batch = 8;
  EXPECT_NE(message_of(MakeProblem(), options).find("1 to 7"), std::string::npos);
  options = MakeOptions();
  options.optimizer = "ADAM";
  EXPECT_NE(message_of(MakeProblem(), options).find("ADAM"), std::string::npos);
  EXPECT_THROW(ParseLearningMethod("our"), std::invalid_argument);
  EXPECT_EQ(ParseLearningMethod("simple_continual"), LearningMethod::kSimpleContinual);
}

// What optimize leaves out stays where it is, whatever the method, and is never chosen.
TEST(ScheduleTest, FixedParametersNeverMove) {
  for (const LearningMethod method :
       {LearningMethod::kOurs, LearningMethod::kSimpleContinual, LearningMethod::kDiffHand}) {
    Problem problem = MakeProblem();
    problem.parameters.fixed = {false, true, false, true, false, false, true};
    QuadraticService service(kWeights, kOptimum);
    Recorder recorder;
    const LearningResult result = Learn(problem, MakeOptions(method), service, recorder);
    for (std::size_t i = 0; i < kDimensions; ++i) {
      EXPECT_EQ(result.theta[i] == problem.parameters.initial[i], problem.parameters.fixed[i]) << i;
    }
    for (const BatchBox& box : recorder.boxes) {
      for (const std::size_t i : box.dimensions) EXPECT_FALSE(problem.parameters.IsFixed(i));
    }
    if (method == LearningMethod::kOurs) {
      EXPECT_GT(result.restarts, 0);
    }
  }
}

// A scene that does not vary: one rollout an evaluation, to the optimum.
TEST(ScheduleTest, OneFixedVariationIsOptimised) {
  Problem problem = MakeProblem();
  problem.variations.clear();
  LearningOptions options = MakeOptions(LearningMethod::kDiffHand);
  options.variations = options.batch = 1;
  options.max_evaluations = 100;
  QuadraticService service(kWeights, kOptimum);
  Recorder recorder;
  const LearningResult result = Learn(problem, options, service, recorder);
  EXPECT_LT(CalcDistance(result.theta, kOptimum), 1e-2);
  EXPECT_EQ(result.rollouts, result.evaluations);
}

}  // namespace schedule_test
}  // namespace knap
