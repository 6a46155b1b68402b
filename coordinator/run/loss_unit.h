// The unit in which a scenario's loss is printed.
#pragma once

#include <string>

#include "sim/scenarios/scene.h"

namespace knap {

// What follows a task loss: " mm²" or " cm" where all its terms are squares or absolute values on that scale;
// " (lengths in cm)" where terms of other kinds are among them; empty where no term has a unit, or their scales differ.
// Weights are numbers without a unit.
std::string FormatLossUnit(const Scene& scene);

}  // namespace knap
