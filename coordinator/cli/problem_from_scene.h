// What the schedule needs to know of a scene: bounded parameters, the distribution of variations, hyperparameters.
#pragma once

#include <cstdint>

#include "coordinator/learning/learning_options.h"
#include "coordinator/learning/problem.h"
#include "sim/scenarios/scene.h"

namespace knap {

// Design parameters by their names, then controls as "control[interval][actuator]"; what `learning.optimize` does not
// name is fixed. Throws std::invalid_argument for a scene without either: nothing can be learned from it.
Problem MakeProblem(const Scene& scene);

// Throws std::invalid_argument for what only the optimizer can refuse, such as an unknown algorithm.
LearningOptions MakeLearningOptions(const Scene& scene);

// Rollouts that learning asks for if every batch uses all the evaluations it may, or the budget.
std::int64_t CalcMostRollouts(const LearningOptions& options);

}  // namespace knap
