// Turns a scene's policy into what the simulator asks: a network between signals and actuators.
#pragma once

#include <Eigen/Core>

#include "sim/policy/closed_loop.h"
#include "sim/rollout/build_model.h"
#include "sim/rollout/build_signals.h"
#include "sim/scenarios/scene.h"

namespace knap {

Network MakeNetwork(const Policy& policy);

// Number of weights of a scene's policy; 0 without one.
int CountWeights(const World& world);

// `scene` has a policy.
ClosedLoop MakeClosedLoop(const Scene& scene, const SignalSet& signals, const SceneModel& model,
                          const Eigen::VectorXd& weights);

}  // namespace knap
