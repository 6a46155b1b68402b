// Parameters as a report shows them: those of the design alone, as controls and weights are too many to be looked at.
#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "coordinator/learning/problem.h"

namespace knap {

// The design's part of d values.
std::vector<double> TakeDesign(const ParameterSpec& parameters, const std::vector<double>& theta);

// names, kinds (units), lower, upper.
nlohmann::ordered_json MakeBoundsJson(const ParameterSpec& parameters);

}  // namespace knap
