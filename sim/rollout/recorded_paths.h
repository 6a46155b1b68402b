// The paths that prescribed motions follow (PathMotion, JointPathMotion): read once, the same in every rollout.
#pragma once

#include <map>
#include <string>
#include <utility>

#include "sim/math/cubic_spline.h"
#include "sim/scenarios/scene.h"

namespace knap {

inline constexpr const char* kPathColumns[] = {"x", "y", "z", "roll", "pitch", "yaw"};

using RecordedPaths = std::map<std::pair<std::string, std::string>, CubicSpline>;  // by the file, the column

// `files` as in scenario_files.h. Throws std::runtime_error with one line that names the body where a file is no table,
// lacks a column, or its times do not ascend.
RecordedPaths ReadRecordedPaths(const World& world, const std::map<std::string, std::string>& files);

}  // namespace knap
