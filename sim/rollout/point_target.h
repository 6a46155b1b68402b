// Distance of a body's point from targets that change with time [PointTargetLoss in scene.h], with its cotangents.
//
//   L = weight/unit Σ_n ‖p_n − target_n‖,  p_n = p_WBo + R_WB p_B at t_n
//   bar_p = weight/unit (p_n − target_n)/‖p_n − target_n‖, zero where the point is on its target
#pragma once

#include <Eigen/Core>
#include <vector>

#include "sim/gradient/adjoint.h"
#include "sim/integrators/simulate.h"
#include "sim/scenarios/scene.h"

namespace knap {

// `body` is loss.body's index in the tree. Adds to *states, and to *bar_point the cotangent of loss.point.
double EvaluatePointTarget(const PointTargetLoss& loss, double step, const Trajectory& trajectory, int body,
                           Dynamics* dynamics, std::vector<StateCotangent>* states, Eigen::Vector3d* bar_point);

}  // namespace knap
