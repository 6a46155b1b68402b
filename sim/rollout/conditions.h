// Whether a rollout does what a condition asks [objective.h].
#pragma once

#include "sim/rollout/loss_terms.h"
#include "sim/scenarios/scene.h"

namespace knap {

bool Holds(const Condition& condition, const Watched& watched);

}  // namespace knap
