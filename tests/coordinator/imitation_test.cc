// Demonstrations and the network that imitates them.
#include "coordinator/imitation/imitation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <mutex>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

#include "coordinator/imitation/demonstrations.h"
#include "coordinator/random/counter_random.h"
#include "tests/coordinator/closed_form_service.h"

namespace knap {
namespace imitation_test {

using Eigen::VectorXd;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

VectorXd DrawVector(Eigen::Index size, double scale, std::uint64_t index) {
  CounterRandom random(7, RandomStream::kRandomThetas, index);
  VectorXd x(size);
  for (double& value : x) value = random.DrawUniform(-scale, scale);
  return x;
}

// What the network with the given weights does at `n` random places.
Examples MakeExamples(Network network, const VectorXd& weights, std::uint64_t n) {
  Examples examples;
  for (std::uint64_t i = 0; i < n; ++i) {
    examples.seen.push_back(DrawVector(network.num_inputs(), 1.0, 100 + i));
    examples.wanted.push_back(network.Calc(weights, examples.seen.back()));
  }
  return examples;
}

std::vector<double> MakeStart(const Network& network) {
  const VectorXd start = DrawVector(network.num_weights(), 0.1, 1);
  return {start.begin(), start.end()};
}

class LinearPolicyTest : public ::testing::TestWithParam<bool> {};

TEST_P(LinearPolicyTest, IsFoundFromItsOwnData) {
  const Network network(5, {}, 2, GetParam());
  const VectorXd truth = DrawVector(network.num_weights(), 0.8, 2);
  const Imitation found = Imitate(network, MakeExamples(network, truth, 60), MakeStart(network), {});
  EXPECT_GT(found.start_error, 0.1);
  // The optimum is unique, and L-BFGS converges to it until the error's own rounding, 1e-16, hides the slope.
  EXPECT_LT(found.error, 1e-6);
  for (Eigen::Index i = 0; i < truth.size(); ++i) {
    EXPECT_NEAR(found.weights[static_cast<std::size_t>(i)], truth(i), 1e-5) << i;
  }
}

INSTANTIATE_TEST_SUITE_P(Outputs, LinearPolicyTest, ::testing::Values(false, true));

TEST(Imitation, AWeightAtItsBoundStaysThereAndTheOthersMakeUpForIt) {
  const Network network(1, {}, 1, false);
  Examples examples;  // y = 2 x + 1
  for (const double x : {1.0, 3.0}) {
    examples.seen.push_back(VectorXd::Constant(1, x));
    examples.wanted.push_back(VectorXd::Constant(1, 2 * x + 1));
  }
  // With both at most 1.5 neither has an optimum within: the slope wants 1.8 at that bias, the bias 2 at that slope.
  const Imitation found = Imitate(network, examples, {0.0, 0.0}, {.lower = -5.0, .upper = 5.0});
  EXPECT_NEAR(found.weights[0], 2.0, 1e-5);
  EXPECT_NEAR(found.weights[1], 1.0, 1e-5);
  const Imitation bounded = Imitate(network, examples, {0.0, 0.0}, {.lower = -1.0, .upper = 1.5});
  EXPECT_EQ(bounded.weights[0], 1.5);
  EXPECT_EQ(bounded.weights[1], 1.5);
}

TEST(Imitation, AHiddenLayerLearnsWhatIsNotLinear) {
  const Network network(2, {8}, 1, true);
  Examples examples;
  for (std::uint64_t i = 0; i < 100; ++i) {
    examples.seen.push_back(DrawVector(2, 1.0, 100 + i));
    const VectorXd& x = examples.seen.back();
    examples.wanted.push_back(VectorXd::Constant(1, 0.8 * std::sin(2.5 * x(0)) * x(1)));
  }
  const Imitation linear = Imitate(Network(2, {}, 1, true), examples, {0.1, 0.1, 0.0}, {});
  const Imitation found = Imitate(network, examples, MakeStart(network), {});
  EXPECT_LT(found.error, 0.2 * linear.error);
  EXPECT_EQ(Imitate(network, examples, MakeStart(network), {}).weights, found.weights);
}

TEST(Imitation, WhatDoesNotFitIsRefused) {
  const Network network(2, {}, 1, true);
  const Examples good = MakeExamples(network, VectorXd::Zero(3), 3);
  EXPECT_THAT([&] { Imitate(network, good, {0.0}, {}); }, ThrowsMessage<std::invalid_argument>(HasSubstr("1 weights")));
  EXPECT_THAT(
      [&] {
        Imitate(network, {}, {0, 0, 0}, {});
      },
      ThrowsMessage<std::invalid_argument>(HasSubstr("no example")));
  Examples narrow = good;
  narrow.seen[1] = VectorXd::Zero(1);
  EXPECT_THAT(
      [&] {
        Imitate(network, narrow, {0, 0, 0}, {});
      },
      ThrowsMessage<std::invalid_argument>(HasSubstr("1 numbers seen; expected 2")));
}

// ---- Demonstrations -------------------------------------------------------------------------------------------------

Problem MakeProblem() {
  Problem problem;
  problem.parameters = {.names = {"a", "b"}, .lower = {-2, -2}, .upper = {2, 2}, .initial = {0, 0}};
  problem.variations = {{.names = {"x", "y"}, .distribution = BallDraw{{0.0, 0.0}, 1.0}}};
  return problem;
}

TEST(Demonstrations, EveryVariationGetsTheOptimumOfItsOwn) {
  const Problem problem = MakeProblem();
  QuadraticService service({1.0, 3.0}, {0.3, -0.2});
  int evaluations = 0, ends = 0;
  DemonstrationOptions options{.variations = 6, .seed = 4};
  options.learning.max_evaluations = 40;
  options.learning.loss_tolerance = 0.0;
  // Rounds are one at a time, but members speak from threads of their own: count what is asked under no lock of ours.
  std::mutex mutex;
  const std::vector<Demonstration> found = FindDemonstrations(problem, options, service,
                                                              {.on_evaluation =
                                                                   [&](std::size_t) {
                                                                     const std::lock_guard lock(mutex);
                                                                     ++evaluations;
                                                                   },
                                                               .on_end =
                                                                   [&](std::size_t, const Demonstration&) {
                                                                     const std::lock_guard lock(mutex);
                                                                     ++ends;
                                                                   }});
  ASSERT_EQ(found.size(), 6u);
  EXPECT_EQ(ends, 6);
  int sum = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_EQ(found[i].variation, SampleVariation(problem.variations, 4, RandomStream::kDemonstrations, i));
    EXPECT_NEAR(found[i].theta[0], 0.3 + found[i].variation[0], 1e-3);
    EXPECT_NEAR(found[i].theta[1], -0.2 + found[i].variation[1], 1e-3);
    EXPECT_TRUE(found[i].success && found[i].trusted);
    sum += found[i].evaluations;
  }
  EXPECT_EQ(evaluations, sum);
  EXPECT_NE(found[0].variation, found[1].variation);
  // Together, not one after the other: at first all are asked in one call.
  EXPECT_EQ(service.calls.front().size(), 6u);
}

// A valley that leads away from success: only who starts beyond the ridge comes there.
TEST(Demonstrations, WhatFailsTriesAgainFromTheNearestSuccess) {
  // Loss (a² − 1)² + 0.3 a + …, least at a = −1 and at a = 1 alike but for the slope; success is a > 0. From a = 0 the
  // search goes to a < 0, unless the variation, x > 0, tilts it the other way.
  class TwoValleys : public RolloutService {
   public:
    std::vector<RolloutOutcome> Evaluate(std::span<const RolloutQuery> queries) override {
      std::vector<RolloutOutcome> outcomes;
      for (const RolloutQuery& query : queries) {
        const double a = query.theta[0], b = query.theta[1], tilt = query.variation[0] > 0.0 ? -0.3 : 0.3;
        RolloutOutcome& outcome = outcomes.emplace_back();
        outcome.certificate = {.finite = true, .converged = true, .gradient_reliable = true};
        outcome.loss = (a * a - 1) * (a * a - 1) + tilt * a + (b - query.variation[1]) * (b - query.variation[1]);
        if (query.gradient) outcome.gradient = {4 * a * (a * a - 1) + tilt, 2 * (b - query.variation[1])};
        outcome.success = a > 0.0;
      }
      return outcomes;
    }
  };
  TwoValleys service;
  DemonstrationOptions options{.variations = 12};
  options.learning.max_evaluations = 40;
  const std::vector<Demonstration> once = FindDemonstrations(MakeProblem(), options, service, {});
  for (const Demonstration& d : once) EXPECT_EQ(d.success, d.variation[0] > 0.0);
  std::vector<std::pair<int, std::size_t>> rounds;
  options.rounds = 5;
  const std::vector<Demonstration> again = FindDemonstrations(
      MakeProblem(), options, service,
      {.on_round = [&](int round, std::size_t variations) { rounds.emplace_back(round, variations); }});
  const auto failed = static_cast<std::size_t>(
      std::count_if(once.begin(), once.end(), [](const Demonstration& d) { return !d.success; }));
  ASSERT_TRUE(failed > 0 && failed < 12) << failed;
  EXPECT_EQ(rounds, (std::vector<std::pair<int, std::size_t>>{{0, 12}, {1, failed}}));
  for (std::size_t i = 0; i < again.size(); ++i) {
    EXPECT_TRUE(again[i].success);
    EXPECT_EQ(again[i].round, once[i].success ? 0 : 1);
    EXPECT_NEAR(again[i].theta[1], again[i].variation[1], 1e-2);  // its own optimum all the same
    if (once[i].success) {
      EXPECT_EQ(again[i].theta, once[i].theta);
    }
  }
}

TEST(Demonstrations, WhatIsNotToBeTrustedIsNoSuccess) {
  QuadraticService service({1.0, 1.0}, {0.0, 0.0});
  service.spoil = [](const RolloutQuery& query, RolloutOutcome& outcome) {
    if (!query.gradient && query.variation[0] > 0.0) outcome.certificate.distrust = "pressed through";
  };
  DemonstrationOptions options{.variations = 8};
  const std::vector<Demonstration> found = FindDemonstrations(MakeProblem(), options, service, {});
  int successes = 0;
  for (const Demonstration& d : found) {
    EXPECT_EQ(d.success, d.variation[0] <= 0.0);
    successes += d.success;
  }
  EXPECT_TRUE(successes > 0 && successes < 8) << successes;

  // Without a success test of the task, trust is what counts.
  service.spoil = [](const RolloutQuery&, RolloutOutcome& outcome) { outcome.success = false; };
  for (const Demonstration& d : FindDemonstrations(MakeProblem(), options, service, {})) EXPECT_FALSE(d.success);
  options.has_success = false;
  for (const Demonstration& d : FindDemonstrations(MakeProblem(), options, service, {})) EXPECT_TRUE(d.success);
}

TEST(Demonstrations, AnErrorOfTheServiceComesOut) {
  QuadraticService service({1.0, 1.0}, {0.0, 0.0});
  service.spoil = [&](const RolloutQuery&, RolloutOutcome&) {
    if (service.calls.size() > 2) throw std::runtime_error("no workers");
  };
  EXPECT_THAT([&] { FindDemonstrations(MakeProblem(), {.variations = 3}, service, {}); },
              ThrowsMessage<std::runtime_error>(HasSubstr("no workers")));
  EXPECT_THAT([&] { FindDemonstrations(MakeProblem(), {.variations = 0}, service, {}); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("variations is 0")));
}

}  // namespace imitation_test
}  // namespace knap
