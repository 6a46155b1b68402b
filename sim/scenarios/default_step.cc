#include "sim/scenarios/default_step.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <variant>

namespace knap {

double CalcDefaultStep(const Scene& scene) {
  constexpr double kUnit = 1e-9;  // [s]
  std::int64_t divisor = 0;
  const auto take = [&divisor](double time) { divisor = std::gcd(divisor, std::llround(time / kUnit)); };
  const auto take_height = [&take](const HeightLoss& loss) {
    for (const double time : {loss.sample_period, loss.from, loss.until}) take(time);
  };
  take(scene.rollout.horizon);
  for (const TaskTerm& term : scene.loss.task) {
    if (const auto* hold = std::get_if<HeightHoldLoss>(&term)) take_height(hold->height);
    if (const auto* target = std::get_if<PointTargetLoss>(&term)) take(target->sample_period);
  }
  for (const DistillationTerm& term : scene.loss.distillation) {
    if (const auto* match = std::get_if<PositionMatchLoss>(&term)) take(match->sample_period);
    if (const auto* height = std::get_if<HeightLoss>(&term)) take_height(*height);
  }
  if (scene.controls) take(scene.controls->interval);
  if (scene.policy) take(scene.policy->interval);
  const std::int64_t longest = std::llround(kLongestDefaultStep / kUnit);
  divisor = std::max<std::int64_t>(divisor, 1);
  const std::int64_t parts = (divisor + longest - 1) / longest;
  return kUnit * static_cast<double>(divisor) / static_cast<double>(parts);
}

}  // namespace knap
