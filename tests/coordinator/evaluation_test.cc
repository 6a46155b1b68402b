#include "coordinator/learning/evaluation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <stdexcept>
#include <vector>

namespace knap {
namespace evaluation_test {

RolloutOutcome MakeOutcome(double loss, bool success, bool converged = true) {
  RolloutOutcome outcome;
  outcome.loss = loss;
  outcome.success = success;
  outcome.certificate = {.finite = std::isfinite(loss), .converged = converged, .gradient_reliable = true};
  return outcome;
}

// Published examples: E. B. Wilson's interval at 95% for 15 of 20 and 81 of 263 (the latter in R. G. Newcombe,
// Statistics in Medicine 17, 1998, Table I, method 3: 0.2553 to 0.3662), and 0 of 20 (0 to 0.1611).
TEST(EvaluationTest, WilsonIntervalGivesThePublishedLimits) {
  const Interval newcombe = CalcWilsonInterval(81, 263);
  EXPECT_NEAR(newcombe.lower, 0.2553, 5e-5);
  EXPECT_NEAR(newcombe.upper, 0.3662, 5e-5);
  const Interval none = CalcWilsonInterval(0, 20);
  EXPECT_EQ(none.lower, 0.0);
  EXPECT_NEAR(none.upper, 0.1611, 5e-5);
  const Interval all = CalcWilsonInterval(20, 20);
  EXPECT_EQ(all.upper, 1.0);
  EXPECT_NEAR(all.lower, 1.0 - 0.1611, 5e-5);
  EXPECT_THROW(CalcWilsonInterval(1, 0), std::invalid_argument);
}

TEST(EvaluationTest, UntrustedRolloutsAreCountedAndTheDeepestIsNamed) {
  std::vector<RolloutOutcome> outcomes;
  for (int i = 0; i < 6; ++i) outcomes.push_back(MakeOutcome(i, i < 2));
  outcomes[3].certificate.distrust = "pea in tool, 61%";
  outcomes[3].certificate.penetration = 0.61;
  outcomes[4].certificate.distrust = "pea in tool, 74%";
  outcomes[4].certificate.penetration = 0.74;
  outcomes[5] = MakeOutcome(std::numeric_limits<double>::quiet_NaN(), false);
  const TestSummary summary = SummarizeTest(outcomes, 1);
  EXPECT_EQ(summary.untrusted, 2);
  EXPECT_EQ(summary.distrust, "pea in tool, 74%");
  EXPECT_EQ(summary.not_finite, 1);
  EXPECT_EQ(SummarizeTest(std::span(outcomes).first(3), 1).untrusted, 0);
}

TEST(EvaluationTest, SummaryCountsAndAverages) {
  std::vector<RolloutOutcome> outcomes;
  for (int i = 1; i <= 20; ++i) outcomes.push_back(MakeOutcome(i, i <= 15));
  const TestSummary summary = SummarizeTest(outcomes, 42);
  EXPECT_EQ(summary.variations, 20);
  EXPECT_EQ(summary.seed, 42u);
  EXPECT_DOUBLE_EQ(summary.loss_mean, 10.5);
  EXPECT_NEAR(summary.loss_std, std::sqrt(35.0), 1e-13);  // (n² - 1)/12 · n/(n-1) for 1 … n
  EXPECT_NEAR(summary.loss_interval.upper - 10.5, 1.959964 * std::sqrt(35.0 / 20.0), 1e-6);
  EXPECT_DOUBLE_EQ(summary.worst_decile_loss, 19.5);
  EXPECT_DOUBLE_EQ(summary.success_rate, 0.75);
  EXPECT_EQ(summary.success_interval.lower, CalcWilsonInterval(15, 20).lower);
  EXPECT_EQ(summary.not_converged, 0);
}

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// The losses count as 1, 3, 3, 2.
TEST(EvaluationTest, FailedRolloutsCountAsTheWorst) {
  const std::vector<RolloutOutcome> outcomes = {MakeOutcome(1, true), MakeOutcome(3, true, false),
                                                MakeOutcome(kNaN, true), MakeOutcome(2, false)};
  const TestSummary summary = SummarizeTest(outcomes, 0);
  EXPECT_EQ(summary.not_converged, 1);
  EXPECT_EQ(summary.not_finite, 1);
  EXPECT_DOUBLE_EQ(summary.success_rate, 0.25);
  EXPECT_DOUBLE_EQ(summary.loss_mean, 2.25);
  EXPECT_NEAR(summary.loss_std, std::sqrt(2.75 / 3.0), 1e-15);
  EXPECT_NEAR(summary.loss_interval.upper - 2.25, 1.959964 * std::sqrt(2.75 / 12.0), 1e-6);
  EXPECT_DOUBLE_EQ(summary.worst_decile_loss, 3.0);
}

// A rollout that did not converge and says that its loss is small.
TEST(EvaluationTest, ASmallLossOfAFailedRolloutIsNotBelieved) {
  const std::vector<RolloutOutcome> outcomes = {MakeOutcome(5, true), MakeOutcome(0, true, false)};
  EXPECT_DOUBLE_EQ(SummarizeTest(outcomes, 0).loss_mean, 5.0);
}

// Whatever fails beside the worst, and however many, no figure of a design improves.
TEST(EvaluationTest, FailingNeverMakesADesignLookBetter) {
  std::vector<RolloutOutcome> sound;
  for (int i = 0; i < 30; ++i) sound.push_back(MakeOutcome((i * 7) % 30, i % 2 == 0));
  const TestSummary before = SummarizeTest(sound, 0);
  for (std::size_t first = 0; first < sound.size(); ++first) {
    std::vector<RolloutOutcome> outcomes = sound;
    for (std::size_t i = first; i < std::min(first + 4, sound.size()); ++i) {
      if (sound[i].loss < 29.0) outcomes[i] = MakeOutcome(kNaN, true, false);
    }
    const TestSummary after = SummarizeTest(outcomes, 0);
    EXPECT_GE(after.loss_mean, before.loss_mean);
    EXPECT_GE(after.worst_decile_loss, before.worst_decile_loss);
    EXPECT_LE(after.success_rate, before.success_rate);
  }
}

TEST(EvaluationTest, WithoutAFiniteLossADesignIsInfinitelyBad) {
  const std::vector<RolloutOutcome> hopeless = {MakeOutcome(kNaN, false), MakeOutcome(kNaN, true)};
  const TestSummary summary = SummarizeTest(hopeless, 0);
  EXPECT_EQ(summary.loss_mean, kInfinity);
  EXPECT_EQ(summary.loss_std, kInfinity);
  EXPECT_EQ(summary.worst_decile_loss, kInfinity);
  EXPECT_EQ(summary.loss_interval.lower, kInfinity);
  EXPECT_EQ(summary.success_rate, 0.0);
  EXPECT_EQ(summary.not_finite, 2);
  const std::vector<TestSummary> seeds = {summary, SummarizeTest(std::vector{MakeOutcome(1, true)}, 0)};
  const SeedSpread spread = SummarizeSeeds(seeds);
  EXPECT_EQ(spread.loss_mean.mean, kInfinity);
  EXPECT_EQ(spread.loss_mean.standard_deviation, kInfinity);
  EXPECT_DOUBLE_EQ(spread.success_rate.mean, 0.5);
}

// Answers loss = variation[0]; success when it is below 0.5; remembers what it was asked.
class EchoService : public RolloutService {
 public:
  std::vector<RolloutOutcome> Evaluate(std::span<const RolloutQuery> queries) override {
    ++calls;
    asked.assign(queries.begin(), queries.end());
    std::vector<RolloutOutcome> outcomes;
    for (const RolloutQuery& query : queries) {
      outcomes.push_back(MakeOutcome(query.variation[0], query.variation[0] < 0.5));
    }
    return outcomes;
  }
  int calls = 0;
  std::vector<RolloutQuery> asked;
};

TEST(EvaluationTest, TestVariationsAreReproducibleAndNotTheTrainingOnes) {
  const VariationSpec spec = {{{"start.x"}, UniformDraw{0.0, 1.0}}, {{"friction"}, NormalDraw{0.4, 0.05}}};
  EchoService service;
  const TestResult result = EvaluateDesign(spec, {0.1, 0.2}, 200, 9, service);
  EXPECT_EQ(service.calls, 1);
  ASSERT_EQ(service.asked.size(), 200u);
  for (std::size_t i = 0; i < 200; ++i) {
    const RolloutQuery& query = service.asked[i];
    EXPECT_EQ(query.theta, (std::vector<double>{0.1, 0.2}));
    EXPECT_TRUE(query.theta_reference.empty());
    EXPECT_FALSE(query.gradient);
    EXPECT_EQ(query.variation, SampleVariation(spec, 9, RandomStream::kTestVariations, i));
    EXPECT_NE(query.variation, SampleVariation(spec, 9, RandomStream::kTrainingVariations, i));
    EXPECT_EQ(result.outcomes[i].loss, query.variation[0]);
  }
  // 200 uniform draws: mean within 5 · 1/sqrt(12 · 200), rate within 5 · sqrt(1/800).
  EXPECT_NEAR(result.summary.loss_mean, 0.5, 0.1);
  EXPECT_NEAR(result.summary.success_rate, 0.5, 0.18);
  // More variations begin with the same ones.
  const TestResult fewer = EvaluateDesign(spec, {0.1, 0.2}, 50, 9, service);
  for (std::size_t i = 0; i < 50; ++i) EXPECT_EQ(fewer.outcomes[i].loss, result.outcomes[i].loss);
}

TEST(EvaluationTest, SeedsAreSummarized) {
  std::vector<TestSummary> tests(3);
  for (int i = 0; i < 3; ++i) {
    tests[static_cast<std::size_t>(i)].loss_mean = 1.0 + i;
    tests[static_cast<std::size_t>(i)].success_rate = 0.9;
  }
  const SeedSpread spread = SummarizeSeeds(tests);
  EXPECT_EQ(spread.seeds, 3);
  EXPECT_DOUBLE_EQ(spread.loss_mean.mean, 2.0);
  EXPECT_DOUBLE_EQ(spread.loss_mean.standard_deviation, 1.0);
  EXPECT_NEAR(spread.success_rate.standard_deviation, 0.0, 1e-15);
}

}  // namespace evaluation_test
}  // namespace knap
