#include "coordinator/learning/failed_rollouts.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace knap {
bool HasFailed(const RolloutOutcome& outcome) {
  return !outcome.certificate.finite || !outcome.certificate.converged || !std::isfinite(outcome.loss);
}

std::vector<double> CountLosses(std::span<const RolloutOutcome> outcomes) {
  std::optional<double> worst;
  for (const RolloutOutcome& outcome : outcomes) {
    if (std::isfinite(outcome.loss)) worst = std::max(worst.value_or(outcome.loss), outcome.loss);
  }
  std::vector<double> losses;
  losses.reserve(outcomes.size());
  for (const RolloutOutcome& outcome : outcomes) {
    losses.push_back(HasFailed(outcome) ? worst.value_or(std::numeric_limits<double>::infinity()) : outcome.loss);
  }
  return losses;
}

}  // namespace knap
