// Robots as others describe them, in URDF, turned into bodies that a scenario includes (include_files.h).
//
// A link becomes a body with the link's name and the joint that leads to it; the root is fixed to the world. Frames
// agree: URDF's link frame is B, its joint frame J. Inertias become explicit ones about the centre of mass along the
// axes of B. Limits become springs at the ends of the range: URDF says nothing about how stiff a stop is, so a joint
// that presses with the whole of its effort gives way by kStopTravel. Efforts become force actuators. Collision shapes
// are taken; what is only seen is not.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sim/scenarios/scene.h"

namespace knap {

inline constexpr double kStopTravel = 0.01;           // [rad, m]
inline constexpr double kEffortWithoutLimit = 100.0;  // of a stop whose joint has none [N·m, N]

struct UrdfOptions {
  // Of a mesh that the URDF names: its bytes; none where it cannot be found.
  std::function<std::optional<std::string>(const std::string& uri)> read_mesh;
  // Set: joints are not free but follow the columns of this CSV file that have their names.
  std::string path_file;
};

struct ImportedRobot {
  std::string name;
  std::vector<Body> bodies;
  std::map<std::string, std::string> body_of_joint;  // by the joint's name in the URDF
  std::map<std::string, std::string> meshes;         // file that a body names → bytes
  std::vector<std::string> remarks;                  // what was left out or decided, one line each
};

// Throws std::runtime_error with one line that says what the text lacks to be a robot, or names what knap cannot
// represent: a joint that mimics another one, a moving link without mass, a planar joint that is not level in its
// frame.
ImportedRobot ImportUrdf(const std::string& text, const UrdfOptions& options);

// The file to include, with the remarks as comments; `source` and `file` are the names of the URDF and of the file.
std::string FormatImport(const ImportedRobot& robot, std::string_view source, std::string_view file);

}  // namespace knap
