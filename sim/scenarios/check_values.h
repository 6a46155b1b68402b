// What the numbers of a scene must satisfy together, as a function of their values: it holds for what a file says as
// for what a variation draws.
#pragma once

#include <string>
#include <vector>

#include "sim/scenarios/scene.h"

namespace knap {

struct ValueFault {
  std::vector<std::string> paths;  // of the number that is wrong, then of those that it does not fit (numeric_keys.h)
  std::string message;             // what is allowed
};

// Of all numbers that may vary, and of those of ropes. Each lies in its field's own range, else its faults mean
// nothing; what the scene is made of need not be consistent. Pure; some microseconds a body.
std::vector<ValueFault> FindValueFaults(const Scene& scene);

}  // namespace knap
