// Turns a scene's policy into what the simulator asks: a network between observations of the tree and its actuators.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "sim/policy/closed_loop.h"
#include "sim/rollout/build_model.h"
#include "sim/rollout/scene_design.h"
#include "sim/scenarios/scene.h"

namespace knap {

Network MakeNetwork(const Policy& policy);

// Number of weights of a scene's policy; 0 without one.
int CountWeights(const Scene& scene);

// `scene` varied, with attachments where the file has them: observed numbers are its. `moved` has them where theta
// does: observed points are its. Both have a policy; `model` was built from `moved`.
ClosedLoop MakeClosedLoop(const Scene& scene, const Scene& moved, const SceneModel& model,
                          const Eigen::VectorXd& weights);

// Of the observed points of bodies, from their cotangents in the order of the observations.
std::vector<PointCotangent> ListObservedPoints(const Policy& policy, const std::vector<Eigen::Vector3d>& bar_points);

}  // namespace knap
