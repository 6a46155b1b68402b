// How good a design is on variations it never saw [docs/method.md].
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "coordinator/learning/problem.h"
#include "coordinator/rollout_service.h"

namespace knap {

struct Interval {
  double lower = 0.0, upper = 0.0;
};

// The 95% Wilson score interval of a rate, `successes` of `trials`, trials > 0. With z = 1.959964 and p = successes /
// trials: (p + z²/2n ± z sqrt(p(1-p)/n + z²/4n²)) / (1 + z²/n). It stays within [0, 1] and is honest at 0 and n.
Interval CalcWilsonInterval(std::int64_t successes, std::int64_t trials);

// Mean and sample standard deviation (n - 1; 0 for one value) of the values; at least one. Summed in order. Where one
// is infinite, both are.
struct Spread {
  double mean = 0.0;
  double standard_deviation = 0.0;
};
Spread CalcSpread(std::span<const double> values);

// Losses are over all n, a failed rollout's as failed_rollouts.h says; it never counts as a success.
struct TestSummary {
  int variations = 0;  // n
  std::uint64_t seed = 0;
  double loss_mean = 0.0;
  double loss_std = 0.0;
  Interval loss_interval{};        // 95%, of the mean: mean ± 1.959964 std / sqrt(n)
  double worst_decile_loss = 0.0;  // mean of the ceil(n/10) largest losses
  double success_rate = 0.0;       // of all n
  Interval success_interval{};     // 95%, Wilson
  int not_converged = 0;           // rollouts with a finite loss whose certificate says not converged
  int not_finite = 0;              // rollouts without a finite loss
  int untrusted = 0;               // rollouts with a finite loss that tell why they are not to be trusted
  std::string distrust{};          // what that of them tells whose contact is the deepest
};

// One outcome a variation, in index order; at least one. Where no loss is finite, all figures of the loss are infinite.
TestSummary SummarizeTest(std::span<const RolloutOutcome> outcomes, std::uint64_t seed);

// Runs theta on variations 0 … n-1 of a stream of `seed`, in one call of the service, without
// gradients. n >= 1. Throws what the service throws.
struct TestResult {
  TestSummary summary;
  std::vector<RolloutOutcome> outcomes;  // n, in index order
};
TestResult EvaluateDesign(const VariationSpec& variations, const std::vector<double>& theta, int n, std::uint64_t seed,
                          RolloutService& service, RandomStream stream = RandomStream::kTestVariations);

// Whether one design is better than another on the same variations: by success, then by mean loss.
bool IsBetter(const TestSummary& design, const TestSummary& other);

// Whether it is so beyond chance: the 95% intervals of the success rate lie apart, or those of the mean loss do and no
// less succeeds.
bool IsClearlyBetter(const TestSummary& design, const TestSummary& other);

// The same design method over several seeds: spread of each seed's figures.
struct SeedSpread {
  int seeds = 0;
  Spread loss_mean;  // of the seeds' mean losses
  Spread success_rate;
  Spread worst_decile_loss;
};
SeedSpread SummarizeSeeds(std::span<const TestSummary> tests);  // at least one

}  // namespace knap
