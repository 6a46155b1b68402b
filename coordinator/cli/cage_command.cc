#include "coordinator/cli/cage_command.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <filesystem>
#include <iterator>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <system_error>

#include "coordinator/cli/exit_codes.h"
#include "coordinator/cli/length_argument.h"
#include "coordinator/report/cage_picture.h"
#include "coordinator/run/usage_error.h"
#include "coordinator/run_directory/durable_file.h"
#include "lcmtypes/program/standard_streams.h"
#include "lcmtypes/wire/text.h"
#include "sim/geometry/mesh_io.h"
#include "sim/morphology/cage_maker.h"

namespace knap {
namespace {

namespace fs = std::filesystem;

struct CageFlags {
  std::string tool;
  std::string axis, shape = "box", unit = "1 mm", margin, body = "tool", out, picture;
  int stations = 4;
};

TriangleMesh ReadTool(const CageFlags& flags, double unit) {
  std::string bytes;
  try {
    bytes = ReadFile(flags.tool);
  } catch (const std::system_error& error) {
    throw UsageError(error.what());
  }
  try {
    TriangleMesh mesh = ReadMesh(flags.tool, bytes, unit);
    const MeshDefects defects = FindDefects(mesh);
    if (defects.empty()) return mesh;
    throw std::runtime_error(
        fmt::format("{}: must be closed and face outwards; it has {}", flags.tool, defects.Describe()));
  } catch (const std::runtime_error& error) {
    throw UsageError(error.what());
  }
}

std::string FormatNumbers(const Eigen::Vector3d& v) { return fmt::format("[{:g}, {:g}, {:g}]", v.x(), v.y(), v.z()); }

std::string FormatDesign(const MadeCage& made, const CageFlags& flags, const fs::path& cage) {
  std::string text =
      "# Remove the parameters that are not to be learned, with their moves.\n"
      "design:\n  parameters:\n";
  const auto out = std::back_inserter(text);
  for (const CageParameter& p : made.parameters) {
    fmt::format_to(out, "    - {{name: {}, initial: {:.4g} mm, lower: {:.4g} mm, upper: {:.4g} mm}}\n", p.name,
                   1e3 * p.initial, 1e3 * p.lower, 1e3 * p.upper);
  }
  fmt::format_to(out, "  bodies:\n    - name: {}\n      mesh: \"{}\"\n      cage: \"{}\"\n      mesh_unit: {}\n",
                 flags.body, CleanText(flags.tool), CleanText(cage.string()), flags.unit);
  text += "      vertex_groups:\n";
  for (const CageGroup& group : made.groups) {
    fmt::format_to(out, "        - {{name: {}, vertices: [{}]}}\n", group.name, fmt::join(group.vertices, ", "));
  }
  text += "      moves:\n";
  for (const CageParameter& p : made.parameters) {
    for (const CageParameter::Move& move : p.moves) {
      fmt::format_to(out, "        - {{parameter: {}, group: {}, direction: {}}}\n", p.name,
                     made.groups[static_cast<std::size_t>(move.group)].name, FormatNumbers(move.direction));
    }
  }
  return text;
}

CageShape FindShape(const std::string& name) {
  if (name == "box") return CageShape::kBox;
  if (name == "prism") return CageShape::kPrism;
  return CageShape::kFitted;
}

int RunCage(const CageFlags& flags) {
  const double unit = ParseLength(flags.unit, "--unit");
  const TriangleMesh mesh = ReadTool(flags, unit);
  CageOptions options;
  options.axis = flags.axis == "x" ? 0 : flags.axis == "y" ? 1 : 2;
  options.stations = flags.stations;
  options.shape = FindShape(flags.shape);
  options.margin = flags.margin.empty() ? CalcUsualMargin(mesh) : ParseLength(flags.margin, "--margin");
  const MadeCage made = MakeCage(mesh, options);
  fs::path out(flags.out);
  if (flags.out.empty()) {
    out = flags.tool;
    out.replace_filename(out.stem().string() + "_cage.obj");
  }
  if (out.extension() != ".obj")
    throw UsageError(fmt::format("--out: '{}': expected a name that ends with .obj", out.string()));
  // Drawn before anything is written: a picture that cannot be leaves no cage either.
  const std::string picture =
      flags.picture.empty() ? "" : DrawCage(made, mesh, CleanText(fs::path(flags.tool).filename().string()));
  WriteFileAtomically(out, WriteObj(made.cage, unit));
  if (!flags.picture.empty()) WriteFileAtomically(flags.picture, picture);
  WriteMessage(fmt::format("{}: {} vertices around {}, {:.3g} mm wider; paste what stdout has into a scenario\n",
                           CleanText(out.string()), made.cage.vertices.size(), CleanText(flags.tool),
                           1e3 * options.margin));
  WriteOutput(FormatDesign(made, flags, out));
  return kExitDone;
}

}  // namespace

void AddCageCommand(CLI::App* app, std::function<int()>* command) {
  const auto flags = std::make_shared<CageFlags>();
  CLI::App* cage = app->add_subcommand("cage", "Makes a cage around a mesh, and a design to paste into a scenario");
  cage->add_option("tool", flags->tool, "closed triangle mesh, OBJ or STL")->required();
  cage->add_option("--axis", flags->axis, "along which its stations stand: x, y or z")
      ->required()
      ->check(CLI::IsMember({"x", "y", "z"}));
  cage->add_option("--stations", flags->stations, "rings of vertices, from end to end (default: 4)")
      ->check(CLI::Range(2, 100));
  cage->add_option("--shape", flags->shape,
                   "of the rings: box, the rectangle around all; prism, the octagon around all; fitted, a rectangle "
                   "each (default: box)")
      ->check(CLI::IsMember({"box", "prism", "fitted"}));
  cage->add_option("--unit", flags->unit, "length of one unit of the file (default: 1 mm)");
  cage->add_option("--margin", flags->margin,
                   "by which the cage is wider than the mesh (default: a hundredth of the mesh's diagonal)");
  cage->add_option("--body", flags->body, "name of the body in the scenario (default: tool)");
  cage->add_option("--out", flags->out, "the cage's file (default: TOOL_cage.obj beside the mesh)");
  cage->add_option("--picture", flags->picture, "writes an SVG of what each parameter does");
  cage->callback([flags, command] { *command = [flags] { return RunCage(*flags); }; });
}

}  // namespace knap
