// A scene's bodies as the report's page draws them: shapes in each body's frame, designed meshes as functions of theta.
#pragma once

#include <Eigen/Core>
#include <nlohmann/json.hpp>

#include "sim/rollout/recording.h"
#include "sim/rollout/rollout.h"

namespace knap {

// One entry for each body of the recording, in its order: name, whether it moves, shapes. A designed mesh has its
// vertices at both designs and, since the cage moves them linearly, their derivative in every parameter:
// vertices(theta) = initial + Σ_k (theta_k − initial_k) basis_k.
nlohmann::ordered_json MakeBodiesJson(const RolloutModel& model, const Recording& recording,
                                      const Eigen::VectorXd& learned);

// Of the bodies that do not move: place and orientation [px, py, pz, qw, qx, qy, qz] in W by name.
nlohmann::ordered_json MakeFixedPosesJson(const Recording& recording);

}  // namespace knap
