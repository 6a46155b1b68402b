// The step of a scene that names none: the longest of at most kLongestDefaultStep of which the horizon, the times and
// periods of samples, and control intervals are whole multiples.
#pragma once

#include "sim/scenarios/scene.h"

namespace knap {

inline constexpr double kLongestDefaultStep = 4e-3;  // [s]

// In whole nanoseconds; times that are none of these make a step that fits nothing, which CheckScene then reports.
double CalcDefaultStep(const Scene& scene);

}  // namespace knap
