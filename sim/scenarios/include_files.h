// Files whose bodies a scenario takes over: a robot, a gripper, a table.
//
//   include:
//     - {file: arm.yaml, name: arm, parent: table, position: [0 mm, 0 mm, 20 mm]}
//
// A file that is included has bodies, ropes, contacts and grips as a scenario has them, and nothing else but `schema`
// and `description`. All its names get `name` and an underscore in front. `name` itself becomes a body that is fixed to
// `parent` at the given pose, and carries what hangs on `world` in the file. Files that it names are relative to its
// own folder. It includes nothing itself. Overrides and variations see the result, `bodies.arm_hand.joint.…`, and
// messages say where in which file a value stands.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "sim/scenarios/config_tree.h"

namespace knap {

// The text of the file at a path relative to the scenario's folder. Throws std::runtime_error that says why not.
struct IncludedText {
  std::string name;  // as messages show it
  std::string text;
};
using IncludeReader = std::function<IncludedText(const std::string& path)>;

// Replaces the key `include` by what it says. Appends what is wrong to *errors. Returns the files' names, which are the
// `file` of positions. Without a reader the key is an error.
std::vector<std::string> IncludeFiles(ConfigNode* root, const IncludeReader& read, std::vector<ConfigError>* errors);

}  // namespace knap
