// A tool and a rope seen from the side with gravity down, as flat faces from the farthest to the nearest.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "sim/geometry/triangle_mesh.h"
#include "sim/rollout/rollout.h"
#include "sim/scenarios/scene.h"

namespace knap {

struct ShownFace {
  std::vector<Eigen::Vector2d> corners;  // right, up, from the tool's origin [m]
  double depth = 0.0;                    // of its centre, towards the eye [m]
  double light = 0.0;                    // 0 … 1
  bool of_rope = false;
};

// Axes of the eye in W, one a row: right, up and towards it. Up is against gravity, save for a fixed glance from above;
// Wx runs to the right as far as that allows.
Eigen::Matrix3d CalcEye(const Eigen::Vector3d& gravity_W);

// The faces that look towards the eye, farthest first.
std::vector<ShownFace> CalcShownFaces(const TriangleMesh& tool, const std::vector<Pose>& X_WL, const Rope& rope,
                                      const Eigen::Matrix3d& eye);

}  // namespace knap
