// How the schedule bears bad batches, answers that are not to be trusted, and a service that fails.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <stdexcept>

#include "coordinator/learning/schedule.h"
#include "tests/coordinator/closed_form_service.h"
#include "tests/coordinator/schedule_fixture.h"

namespace knap {
namespace schedule_trust_test {

TEST(ScheduleTrustTest, OneBadBatchDoesNotThrowAwayWhatWasLearned) {
  const auto spoil_batch = [](const Problem& problem, std::uint64_t first) {
    return [problem, first](const RolloutQuery& query, RolloutOutcome& outcome) {
      for (std::uint64_t i = first; i < first + 5; ++i) {
        if (!query.theta_reference.empty() ||
            query.variation != SampleVariation(problem.variations, 0, RandomStream::kTrainingVariations, i)) {
          continue;
        }
        outcome.loss = 0.0;  // 10 sum_i theta_i²: the minimum is the corner 0
        for (std::size_t k = 0; k < query.theta.size(); ++k) {
          outcome.loss += 10.0 * query.theta[k] * query.theta[k];
          if (query.gradient) outcome.gradient[k] = 20.0 * query.theta[k];
        }
      }
    };
  };
  const Problem problem = MakeProblem();
  LearningOptions options = MakeOptions();
  options.variations = 90;  // the bad batch is the 18th, the last
  double distance[2];
  for (const LearningMethod method : {LearningMethod::kOurs, LearningMethod::kSimpleContinual}) {
    options.method = method;
    QuadraticService service(kWeights, kOptimum);
    service.spoil = spoil_batch(problem, 85);
    Recorder recorder;
    distance[method == LearningMethod::kOurs ? 0 : 1] =
        CalcDistance(Learn(problem, options, service, recorder).theta, kOptimum);
  }
  EXPECT_LT(distance[0], 0.05);  // two dimensions, radius 0.25 e^-4
  EXPECT_GT(distance[1], 1.0);   // the baseline goes to the corner: |c| = 1.4
}

TEST(ScheduleTrustTest, AFlatBatchIsSkippedAndUsesNothingUp) {
  const Problem problem = MakeProblem();
  QuadraticService service(kWeights, kOptimum);
  service.spoil = [&](const RolloutQuery& query, RolloutOutcome& outcome) {
    for (std::uint64_t i = 5; i < 10; ++i) {  // batch 2
      if (query.theta_reference.empty() &&
          query.variation == SampleVariation(problem.variations, 0, RandomStream::kTrainingVariations, i)) {
        outcome.loss = 0.0;
        std::fill(outcome.gradient.begin(), outcome.gradient.end(), 0.0);
      }
    }
  };
  Recorder recorder;
  LearningOptions options = MakeOptions();
  options.variations = 25;
  Learn(problem, options, service, recorder);
  EXPECT_EQ(recorder.ends[1].stop, BatchStop::kFlat);
  EXPECT_EQ(recorder.ends[1].evaluations, 1);
  EXPECT_EQ(recorder.ends[1].theta, recorder.ends[0].theta);
  std::set<std::size_t> used;
  for (const std::size_t t : {0u, 2u, 3u, 4u}) {
    for (const std::size_t i : recorder.boxes[t].dimensions) used.insert(i);
    EXPECT_FALSE(recorder.boxes[t].restarted);
  }
  EXPECT_EQ(used.size(), kDimensions);
}

TEST(ScheduleTrustTest, AHopelessVariationLeavesItsBatchAndIsCounted) {
  const Problem problem = MakeProblem();
  const std::vector<double> hopeless = SampleVariation(problem.variations, 0, RandomStream::kTrainingVariations, 2);
  QuadraticService service(kWeights, kOptimum);
  std::vector<double> trusted;  // losses of the first batch at its start
  service.spoil = [&](const RolloutQuery& query, RolloutOutcome& outcome) {
    if (query.variation != hopeless) {
      if (trusted.size() < 4) trusted.push_back(outcome.loss);
      return;
    }
    outcome.certificate.converged = false;
    outcome.loss = 1e6;  // must not be used
  };
  Recorder recorder;
  const LearningResult result = Learn(problem, MakeOptions(), service, recorder);
  EXPECT_EQ(recorder.boxes[0].excluded_task, 1);
  EXPECT_EQ(recorder.evaluations[0].value.untrusted, 1);
  EXPECT_EQ(recorder.evaluations[0].value.rollouts, 5);
  EXPECT_EQ(recorder.evaluations[1].value.rollouts, 4);
  // The one that failed counts as the worst of the others.
  const double worst = *std::max_element(trusted.begin(), trusted.end());
  EXPECT_NEAR(recorder.evaluations[0].value.loss, (trusted[0] + trusted[1] + trusted[2] + trusted[3] + worst) / 5.0,
              1e-14);
  EXPECT_EQ(result.rejected, 0);
  EXPECT_EQ(result.untrusted, result.excluded);  // asked once a batch it is in, never again
  EXPECT_GT(result.excluded, 1);                 // in distillation sets, too
  EXPECT_LT(CalcDistance(result.theta, kOptimum), 0.04);
  for (const LearningEvaluation& evaluation : recorder.evaluations) EXPECT_LT(evaluation.value.loss, 100.0);
}

TEST(ScheduleTrustTest, DesignsThatBreakTheSimulatorAreRejectedAndCounted) {
  QuadraticService service(kWeights, kOptimum);
  service.spoil = [](const RolloutQuery& query, RolloutOutcome& outcome) {
    if (query.theta[4] <= 0.6) return;  // its optimum is 0.7
    outcome.certificate.finite = false;
    outcome.loss = std::numeric_limits<double>::quiet_NaN();
    outcome.gradient.clear();
  };
  Recorder recorder;
  const LearningResult result = Learn(MakeProblem(), MakeOptions(), service, recorder);
  EXPECT_LE(result.theta[4], 0.6);
  EXPECT_GT(result.theta[4], 0.5);
  EXPECT_GT(result.rejected, 0);
  EXPECT_GE(result.untrusted, result.rejected);
  for (const LearningEvaluation& evaluation : recorder.evaluations) {
    if (!evaluation.value.accepted) {
      EXPECT_TRUE(std::isinf(evaluation.value.loss));
      EXPECT_TRUE(evaluation.value.gradient.empty());
    }
    EXPECT_TRUE(std::isfinite(evaluation.best_loss));
  }
}

TEST(ScheduleTrustTest, ABatchWithoutATrustedStartLeavesThetaAlone) {
  QuadraticService service(kWeights, kOptimum);
  service.spoil = [](const RolloutQuery&, RolloutOutcome& outcome) { outcome.certificate.converged = false; };
  Recorder recorder;
  const LearningResult result = Learn(MakeProblem(), MakeOptions(), service, recorder);
  EXPECT_EQ(result.theta, MakeProblem().parameters.initial);
  EXPECT_EQ(result.untrusted, result.rollouts);
  for (const BatchEnd& end : recorder.ends) EXPECT_EQ(end.stop, BatchStop::kNothingTrusted);
}

TEST(ScheduleTrustTest, FailuresOfTheServicePassThrough) {
  class FailingService : public RolloutService {
   public:
    std::vector<RolloutOutcome> Evaluate(std::span<const RolloutQuery> queries) override {
      if (++calls == 7) throw std::runtime_error("no workers");
      return inner.Evaluate(queries);
    }
    int calls = 0;
    QuadraticService inner{kWeights, kOptimum};
  };
  FailingService service;
  Recorder recorder;
  EXPECT_THROW(Learn(MakeProblem(), MakeOptions(), service, recorder), std::runtime_error);
  EXPECT_EQ(service.calls, 7);

  class ShortService : public RolloutService {
    std::vector<RolloutOutcome> Evaluate(std::span<const RolloutQuery>) override { return {}; }
  };
  ShortService short_service;
  EXPECT_THROW(Learn(MakeProblem(), MakeOptions(), short_service, recorder), std::runtime_error);
}

}  // namespace schedule_trust_test
}  // namespace knap
