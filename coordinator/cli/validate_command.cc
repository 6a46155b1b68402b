#include "coordinator/cli/validate_command.h"

#include <fmt/format.h>

#include <cmath>
#include <cstddef>
#include <exception>
#include <map>
#include <memory>
#include <string>
#include <system_error>
#include <variant>
#include <vector>

#include "coordinator/cli/exit_codes.h"
#include "coordinator/run/loaded_run.h"
#include "coordinator/run/problem_from_scene.h"
#include "coordinator/run/usage_error.h"
#include "lcmtypes/program/standard_streams.h"
#include "lcmtypes/wire/text.h"
#include "sim/geometry/mesh_io.h"
#include "sim/geometry/mesh_refinement.h"
#include "sim/rollout/built_scene.h"
#include "sim/rollout/design_corners.h"
#include "sim/rollout/rollout.h"
#include "sim/rollout/scene_design.h"
#include "sim/scenarios/check_rules.h"
#include "sim/scenarios/describe_scene.h"

namespace knap {
namespace {

struct ValidateFlags {
  std::string config;
  std::vector<std::string> overrides;
  bool describe = false;
};

std::string Count(std::size_t n, const std::string& what) { return fmt::format("{} {}{}", n, what, n == 1 ? "" : "s"); }

// In mm where it is a length.
std::string FormatValue(const DesignParameter& parameter, double value) {
  const bool shift = parameter.kind == ParameterKind::kShift;
  return fmt::format("{:.6g}{}", value * (shift ? 1000.0 : 1.0), shift ? " mm" : "");
}

// A design that the bounds allow and that folds a mesh is no error: such an evaluation is rejected.
void WarnOfFoldedCorners(const std::string& config, const Scene& scene, const SceneDesign& design) {
  const FoldedCorners corners = FindFoldedCorners(design, *scene.design);
  if (corners.folded == 0) return;
  std::string at;
  for (std::size_t i = 0; i < scene.design->parameters.size(); ++i) {
    const DesignParameter& parameter = scene.design->parameters[i];
    at += fmt::format("{}{} {}", i == 0 ? "" : ", ", parameter.name,
                      FormatValue(parameter, corners.example(static_cast<Eigen::Index>(i))));
  }
  WriteMessage(
      fmt::format("{}: warning: {} of the {} designs tried at the ends of the bounds would be rejected; at {} {}. None "
                  "of them would be at {}% of their way from the initial design\n",
                  CleanText(config), corners.folded, corners.tried, at, corners.fault, corners.safe_percent));
}

std::string FormatMeasures(const TriangleMesh& mesh) {
  const Eigen::Vector3d mm = 1e3 * CalcBoundingBox(mesh).sizes();
  return fmt::format("{:.2f} x {:.2f} x {:.2f} mm, {:.3f} cm^3", mm.x(), mm.y(), mm.z(), 1e6 * CalcSignedVolume(mesh));
}

std::string FormatFineness(const TriangleMesh& mesh) {
  return fmt::format("{} triangles, edges up to {:.2f} mm", mesh.triangles.size(), 1e3 * CalcLongestEdge(mesh));
}

// How large and how fine each designed body is as it is on file, and with each of its parameters alone at either bound.
void ListMeasures(const Scene& scene, const std::map<std::string, std::string>& files, const SceneDesign& design) {
  for (const DesignedBody& designed : scene.design->bodies) {
    const std::string& body = designed.name;
    const CageDesign& cage = *design.Find(body);
    const TriangleMesh on_file = ReadMesh(designed.mesh, files.at(designed.mesh), designed.mesh_unit);
    WriteOutput(
        fmt::format("{}: {} as on file, {}\n", body, FormatMeasures(cage.initial_mesh()), FormatFineness(on_file)));
    if (designed.refine > 0.0) {
      WriteOutput(fmt::format("  {:<20} {:>9} {}\n", "refine", fmt::format("{:.6g} mm", 1e3 * designed.refine),
                              FormatFineness(cage.initial_mesh())));
    }
    for (std::size_t i = 0; i < scene.design->parameters.size(); ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      if (cage.dm_dtheta().col(k).isZero(0.0)) continue;
      const DesignParameter& parameter = scene.design->parameters[i];
      const double initial = design.initial_theta()(k);
      for (const double bound : {parameter.lower, parameter.upper}) {
        Eigen::VectorXd theta = design.initial_theta();
        theta(k) = bound;
        const TriangleMesh mesh = cage.CalcMesh(theta);
        const auto format_fold = [&] {
          const double nearest = initial + 0.01 * FindSafePercent(design, theta) * (bound - initial);
          return fmt::format("folds the mesh; {} does not", FormatValue(parameter, nearest));
        };
        WriteOutput(fmt::format("  {:<20} {:>9} {}\n", bound == parameter.lower ? parameter.name : "",
                                FormatValue(parameter, bound),
                                FindDefects(mesh).empty() ? FormatMeasures(mesh) : format_fold()));
      }
    }
  }
}

void ListPieces(const std::string& config, const std::string& mesh, double volume, const std::vector<double>& pieces) {
  // The mesh itself has its volume up to the order in which it is summed.
  if (pieces.empty() || (pieces.size() == 1 && std::abs(pieces[0] - volume) < 1e-9 * volume)) return;
  std::string shares;
  double sum = 0.0;
  for (const double piece : pieces) {
    shares += fmt::format("{}{:.1f}%", shares.empty() ? "" : " + ", 100.0 * piece / volume);
    sum += piece;
  }
  WriteOutput(fmt::format("{}: {} touches as {}, of its volume {} = {:.1f}%\n", CleanText(config), mesh,
                          Count(pieces.size(), "convex piece"), shares, 100.0 * sum / volume));
}

// What meshes touch as that are not convex, or designed and meet others that are.
void ListPieces(const std::string& config, const RolloutModel& model) {
  for (const auto& [shape, mesh] : model.source().meshes()) {
    const auto& [name, index] = shape;
    const Body& body = *FindBody(model.scene(), name);
    ListPieces(
        config,
        fmt::format("{} of {} is not convex and", CleanText(std::get<MeshShape>(body.shapes[index].kind).file), name),
        mesh.of_unit_density.mass, mesh.volumes);
  }
  if (!model.design()) return;
  for (const std::string& name : model.design()->bodies()) {
    ListPieces(config, fmt::format("the designed mesh of {} meets another and", name),
               CalcSignedVolume(model.design()->Find(name)->initial_mesh()), model.design()->CalcPieceVolumes(name));
  }
}

int RunValidate(const ValidateFlags& flags) {
  if (flags.describe) {
    WriteOutput(DescribeSceneFormat());
    return kExitDone;
  }
  const LoadedScenario scenario = LoadValidScenario(flags.config, flags.overrides);
  const Scene& scene = scenario.parsed.scene;
  try {
    const RolloutModel model(scenario.files);
    if (HasParameters(scene)) MakeLearningOptions(scene);
    ListPieces(flags.config, model);
    if (model.design()) WarnOfFoldedCorners(flags.config, scene, *model.design());
    if (model.design()) ListMeasures(scene, scenario.files, *model.design());
  } catch (const std::system_error&) {
    throw;  // what stdout does not take is no fault of the file
  } catch (const std::exception& error) {
    throw UsageError(fmt::format("{}: {}", flags.config, error.what()));
  }
  const Rollout& rollout = scene.rollout;
  WriteOutput(fmt::format("{}: valid: {}, {}, {}, {}, {} of {} s\n", CleanText(flags.config),
                          fmt::format("{} {}", scene.bodies.size(), scene.bodies.size() == 1 ? "body" : "bodies"),
                          Count(scene.contacts.size(), "contact"),
                          Count(scene.design ? scene.design->parameters.size() : 0, "design parameter"),
                          Count(ListVariedKeys(scene.variation).size(), "varied key"),
                          Count(static_cast<std::size_t>(std::llround(rollout.horizon / rollout.step)), "step"),
                          rollout.step));
  return kExitDone;
}

}  // namespace

void AddValidateCommand(CLI::App* app, std::function<int()>* command) {
  const auto flags = std::make_shared<ValidateFlags>();
  CLI::App* validate = app->add_subcommand("validate", "Reports all errors of a scenario as file:line:column");
  CLI::Option* config = validate->add_option("config", flags->config, "scenario file");
  validate->add_option("overrides", flags->overrides, "changes to it, a.b=c");
  validate->add_flag("--describe", flags->describe, "print the reference of the format instead (docs/scenario.md)")
      ->excludes(config);
  validate->callback([flags, command] {
    if (!flags->describe && flags->config.empty()) throw CLI::RequiredError("config");
    *command = [flags] { return RunValidate(*flags); };
  });
}

}  // namespace knap
