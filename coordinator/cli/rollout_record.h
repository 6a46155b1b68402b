// What is written of one rollout, as JSON and for people.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "coordinator/learning/problem.h"
#include "sim/rollout/rollout.h"

namespace knap {

struct RolloutRecord {
  const Scene& scene;
  const ParameterSpec& parameters;
  const RolloutInput& input;
  const RolloutOutput& output;
  double forward_s, gradient_s;
};

// scenario, theta and variation by name in SI units, loss, success (null without a success test), gradient by name
// (null where there is none), steps, forward_s, gradient_s, certificate. Numbers that are not finite are null.
nlohmann::ordered_json MakeRolloutJson(const RolloutRecord& record);

std::string FormatRollout(const RolloutRecord& record);

}  // namespace knap
