// What the schedule needs to know of a scene: bounded parameters, the distribution of variations, hyperparameters.
#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "coordinator/learning/learning_options.h"
#include "coordinator/learning/problem.h"
#include "sim/scenarios/scene.h"

namespace knap {

// Design parameters by their names, then controls as "control[interval][actuator]", then a policy's weights as
// "policy[index]"; what `learning.optimize` does not name is fixed. Where `learning.start` has values, they stand for
// the initial ones. `files` as LoadScenario gives them: the policy's initial weights may be among them. Throws
// std::invalid_argument for a scene without any of the three, since nothing can be learned from it, and what
// MakeInitialWeights throws.
Problem MakeProblem(const Scene& scene, const std::map<std::string, std::string>& files = {});

// Whether there is anything that MakeProblem could name.
bool HasParameters(const World& world);

// Throws std::invalid_argument for what only the optimizer can refuse, such as an unknown algorithm.
LearningOptions MakeLearningOptions(const Scene& scene);

// Rollouts that learning asks for if every batch uses all the evaluations it may, or the budget.
std::int64_t CalcMostRollouts(const LearningOptions& options);

}  // namespace knap
