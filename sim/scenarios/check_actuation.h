// What a scene's controls, its policy and what learning moves must satisfy beyond what each field may be by itself.
#pragma once

#include <cstdint>

#include "sim/scenarios/field_log.h"
#include "sim/scenarios/scene.h"

namespace knap {

// Controls and weights that a scene may have: with a reference, a request carries them twice, and a message's limit is
// 2^20 values.
inline constexpr std::int64_t kMostWeights = 400000;

// Of the network between the policy's observations and actuators.
std::int64_t CountPolicyWeights(const Policy& policy);

// Reports to the log what is wrong.
void CheckActuation(const Scene& scene, FieldLog& log);

}  // namespace knap
