// How rollouts that failed count where designs are judged [docs/decisions/0012]: never as a success, and with the worst
// finite loss that the design has in the same evaluation, so that failing does not make a design look better. Where
// none of its losses is finite, all are infinite. A design's figures so depend on its own rollouts alone, whoever asks.
#pragma once

#include <span>
#include <vector>

#include "coordinator/rollout_service.h"

namespace knap {

// Not finite or not converged, by its certificate or by its loss.
bool HasFailed(const RolloutOutcome& outcome);

// The losses with which the outcomes of one design count, in their order: their own, or, where they failed, the largest
// finite one, those of failed rollouts included.
std::vector<double> CountLosses(std::span<const RolloutOutcome> outcomes);

}  // namespace knap
