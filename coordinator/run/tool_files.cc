#include "coordinator/run/tool_files.h"

#include <fmt/format.h>

#include <utility>

namespace knap {

std::string NameToolFile(const SceneDesign& design, const std::string& body, const std::string& stem,
                         PrintFormat format) {
  return fmt::format("{}{}.{}", stem, design.bodies().size() == 1 ? "" : "_" + body, GetName(format));
}

std::vector<ToolPart> CheckTool(const SceneDesign& design, const Eigen::VectorXd& theta, PrintFormat format,
                                const Printer& printer) {
  std::vector<ToolPart> parts;
  for (const std::string& body : design.bodies()) {
    TriangleMesh mesh = RoundAsWritten(design.Find(body)->CalcMesh(theta), format);
    PrintCheck check = CheckPrint(mesh, printer);
    parts.push_back({body, std::move(mesh), std::move(check)});
  }
  return parts;
}

}  // namespace knap
