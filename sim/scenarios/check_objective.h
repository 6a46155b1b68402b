// Rules of signals, losses, success and observations: what goes with what, and which numbers fit together.
#pragma once

#include <vector>

#include "sim/scenarios/check_values.h"
#include "sim/scenarios/field_log.h"
#include "sim/scenarios/scene.h"

namespace knap {

// All that no number can change. `scene` stays as it is: visitors take no const one.
void CheckObjective(Scene& scene, FieldLog& log);

// As FindValueFaults.
std::vector<ValueFault> FindObjectiveFaults(const Scene& scene);

}  // namespace knap
