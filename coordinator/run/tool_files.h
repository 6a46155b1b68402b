// The tool as files: each designed body, deformed by theta, in its own frame.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "sim/geometry/print_check.h"
#include "sim/geometry/print_file.h"
#include "sim/rollout/scene_design.h"

namespace knap {

// "STEM.stl" where the design has one body, else "STEM_BODY.stl" [print_file.h: what is in it].
std::string NameToolFile(const SceneDesign& design, const std::string& body, const std::string& stem,
                         PrintFormat format);

// One body that is to be a file.
struct ToolPart {
  std::string body;
  TriangleMesh mesh;  // as the file holds it, in metres
  PrintCheck check;
};

// All of the design at theta, its own parameters, in the order of the file; nothing is written.
std::vector<ToolPart> CheckTool(const SceneDesign& design, const Eigen::VectorXd& theta, PrintFormat format,
                                const Printer& printer);

}  // namespace knap
