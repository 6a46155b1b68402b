// The weights from which a policy's learning starts.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "sim/scenarios/controls.h"

namespace knap {

// Random ones are a pure function of the policy's seed and of each weight's index: normal with standard deviation
// scale/√(inputs of its unit), truncated at three of them, then brought within the bounds; biases 0. `files` holds the
// file that the policy names, if it names one; throws std::runtime_error as ParseWeights does, and when it is missing.
std::vector<double> MakeInitialWeights(const Policy& policy, const std::map<std::string, std::string>& files);

}  // namespace knap
