#include "coordinator/learning/evaluation.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <stdexcept>
#include <string>

#include "coordinator/learning/batch_objective.h"
#include "coordinator/learning/failed_rollouts.h"

namespace knap {
namespace {

constexpr double kNormal975 = 1.959963984540054;  // the 97.5% quantile of the standard normal

double CalcMean(std::span<const double> values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

}  // namespace

Interval CalcWilsonInterval(std::int64_t successes, std::int64_t trials) {
  if (trials <= 0 || successes < 0 || successes > trials) {
    throw std::invalid_argument("CalcWilsonInterval: " + std::to_string(successes) + " of " + std::to_string(trials));
  }
  const auto n = static_cast<double>(trials);
  const double p = static_cast<double>(successes) / n;
  const double z2_n = kNormal975 * kNormal975 / n;
  const double centre = (p + z2_n / 2.0) / (1.0 + z2_n);
  const double half = std::sqrt(z2_n * (p * (1.0 - p) + z2_n / 4.0)) / (1.0 + z2_n);
  // At 0 and n of n the exact limits are 0 and 1; rounding must not miss them.
  return {successes == 0 ? 0.0 : centre - half, successes == trials ? 1.0 : centre + half};
}

Spread CalcSpread(std::span<const double> values) {
  if (values.empty()) throw std::invalid_argument("CalcSpread: no values");
  Spread spread{.mean = CalcMean(values)};
  if (!std::isfinite(spread.mean)) return {spread.mean, std::abs(spread.mean)};
  if (values.size() == 1) return spread;
  double sum = 0.0;
  for (const double value : values) sum += (value - spread.mean) * (value - spread.mean);
  spread.standard_deviation = std::sqrt(sum / static_cast<double>(values.size() - 1));
  return spread;
}

TestSummary SummarizeTest(std::span<const RolloutOutcome> outcomes, std::uint64_t seed) {
  TestSummary summary{.variations = static_cast<int>(outcomes.size()), .seed = seed};
  int successes = 0;
  double deepest = 0.0;
  for (const RolloutOutcome& outcome : outcomes) {
    const RolloutCertificate& certificate = outcome.certificate;
    if (!HasFailed(outcome)) {
      successes += outcome.success ? 1 : 0;
      if (certificate.distrust.empty()) continue;
      if (summary.untrusted == 0 || certificate.penetration > deepest) {
        deepest = certificate.penetration;
        summary.distrust = certificate.distrust;
      }
      ++summary.untrusted;
    } else if (certificate.finite && std::isfinite(outcome.loss)) {
      ++summary.not_converged;
    } else {
      ++summary.not_finite;
    }
  }
  std::vector<double> losses = CountLosses(outcomes);
  const Spread spread = CalcSpread(losses);
  summary.loss_mean = spread.mean;
  summary.loss_std = spread.standard_deviation;
  const double half = kNormal975 * spread.standard_deviation / std::sqrt(static_cast<double>(losses.size()));
  summary.loss_interval = {std::isfinite(half) ? spread.mean - half : spread.mean, spread.mean + half};
  summary.success_rate = static_cast<double>(successes) / static_cast<double>(outcomes.size());
  summary.success_interval = CalcWilsonInterval(successes, summary.variations);
  std::sort(losses.begin(), losses.end(), std::greater<>());
  summary.worst_decile_loss = CalcMean(std::span<const double>(losses).first((losses.size() + 9) / 10));
  return summary;
}

TestResult EvaluateDesign(const VariationSpec& variations, const std::vector<double>& theta, int n, std::uint64_t seed,
                          RolloutService& service, RandomStream stream) {
  if (n < 1) throw std::invalid_argument("test variations: " + std::to_string(n) + "; expected 1 or more");
  std::vector<RolloutQuery> queries;
  for (int i = 0; i < n; ++i) {
    queries.push_back({.theta = theta,
                       .theta_reference = {},
                       .variation = SampleVariation(variations, seed, stream, static_cast<std::uint64_t>(i)),
                       .gradient = false});
  }
  TestResult result{.summary = {}, .outcomes = EvaluateAll(service, queries)};
  result.summary = SummarizeTest(result.outcomes, seed);
  return result;
}

bool IsBetter(const TestSummary& design, const TestSummary& other) {
  if (design.success_rate != other.success_rate) return design.success_rate > other.success_rate;
  return design.loss_mean < other.loss_mean;
}

bool IsClearlyBetter(const TestSummary& design, const TestSummary& other) {
  if (design.success_interval.lower > other.success_interval.upper) return true;
  return design.success_rate >= other.success_rate && design.loss_interval.upper < other.loss_interval.lower;
}

SeedSpread SummarizeSeeds(std::span<const TestSummary> tests) {
  std::vector<double> losses, rates, deciles;
  for (const TestSummary& test : tests) {
    losses.push_back(test.loss_mean);
    rates.push_back(test.success_rate);
    deciles.push_back(test.worst_decile_loss);
  }
  return {static_cast<int>(tests.size()), CalcSpread(losses), CalcSpread(rates), CalcSpread(deciles)};
}

}  // namespace knap
