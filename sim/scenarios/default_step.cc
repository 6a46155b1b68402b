#include "sim/scenarios/default_step.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <variant>

namespace knap {

namespace {

template <class Take>
void TakeTimes(const Condition& condition, const Take& take) {
  std::visit(
      [&](const auto& kind) {
        if constexpr (requires { kind.of; }) {
          for (const Condition& part : kind.of) TakeTimes(part, take);
        } else if (const auto* at = std::get_if<AtTime>(&kind.when)) {
          take(at->time);
        }
      },
      condition.kind);
}

}  // namespace

double CalcDefaultStep(const Scene& scene) {
  constexpr double kUnit = 1e-9;  // [s]
  std::int64_t divisor = 0;
  const auto take = [&divisor](double time) { divisor = std::gcd(divisor, std::llround(time / kUnit)); };
  take(scene.rollout.horizon);
  for (const auto* terms : {&scene.loss.task, &scene.loss.distillation}) {
    for (const Term& term : *terms) {
      if (const auto* at = std::get_if<AtTime>(&term.when)) take(at->time);
      const auto* samples = std::get_if<OverSamples>(&term.when);
      if (samples == nullptr) continue;
      for (const double time : {samples->every, samples->from}) take(time);
    }
  }
  for (const Signal& signal : scene.signals) {
    if (const auto* drift = std::get_if<DriftSignal>(&signal.kind)) take(drift->since);
  }
  if (scene.success) TakeTimes(*scene.success, take);
  if (scene.controls) take(scene.controls->interval);
  if (scene.policy) take(scene.policy->interval);
  const std::int64_t longest = std::llround(kLongestDefaultStep / kUnit);
  divisor = std::max<std::int64_t>(divisor, 1);
  const std::int64_t parts = (divisor + longest - 1) / longest;
  // One division, so that 4 ms is the number that 4 ms is.
  return static_cast<double>(divisor) / (1e9 * static_cast<double>(parts));
}

}  // namespace knap
