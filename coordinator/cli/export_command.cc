#include "coordinator/cli/export_command.h"

#include <fmt/format.h>

#include <cstddef>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "coordinator/cli/exit_codes.h"
#include "coordinator/cli/length_argument.h"
#include "coordinator/cli/run_or_scenario.h"
#include "coordinator/cli/theta_choice.h"
#include "coordinator/run/loaded_run.h"
#include "coordinator/run/problem_from_scene.h"
#include "coordinator/run/tool_files.h"
#include "coordinator/run/usage_error.h"
#include "coordinator/run_directory/durable_file.h"
#include "coordinator/run_directory/json_text.h"
#include "lcmtypes/program/standard_streams.h"
#include "lcmtypes/wire/text.h"
#include "sim/scenarios/check_rules.h"

namespace knap {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;
using Json = nlohmann::ordered_json;

struct ExportFlags {
  std::string path;  // of a scenario file or a run
  std::vector<std::string> overrides;
  std::string theta, format = "stl", out;
  std::string nozzle = "0.4 mm", bed = "250x210x210 mm";
  bool json = false;
};

// "250x210x210 mm": the unit is that of all three.
Vector3d ParseBed(const std::string& text) {
  const std::size_t first = text.find('x');
  const std::size_t second = first == std::string::npos ? first : text.find('x', first + 1);
  if (second == std::string::npos || text.find('x', second + 1) != std::string::npos) {
    throw UsageError(fmt::format("--bed: '{}': expected width, depth and height, such as 250x210x210 mm", text));
  }
  const std::size_t unit = text.find_first_not_of("0123456789.eE+-", second + 1);
  const std::string suffix = unit == std::string::npos ? "" : text.substr(unit);
  const std::string option = "--bed";
  return {ParseLength(text.substr(0, first) + suffix, option),
          ParseLength(text.substr(first + 1, second - first - 1) + suffix, option),
          ParseLength(text.substr(second + 1), option)};
}

// Mass as the scene has it; none where it gives neither that nor a density.
std::optional<double> FindMass(const Body& body, double volume) {
  if (!body.inertia) return std::nullopt;
  if (const auto* density = std::get_if<DensityInertia>(&*body.inertia)) return density->density * volume;
  if (const auto* given = std::get_if<ExplicitInertia>(&*body.inertia)) return given->mass;
  return std::nullopt;
}

std::string FormatPlace(const Vector3d& place) {
  const Vector3d mm = 1e3 * place;
  return fmt::format("({:.2f}, {:.2f}, {:.2f}) mm", mm.x(), mm.y(), mm.z());
}

Json MakeVectorJson(const Vector3d& metres) {
  Json out = Json::array();
  for (int k = 0; k < 3; ++k) out.push_back(MakeJsonNumber(1e3 * metres[k]));
  return out;
}

Json MakeNarrowJson(const std::optional<NarrowPlace>& narrow) {
  if (!narrow) return nullptr;
  return {{"width_mm", 1e3 * narrow->width},
          {"place_mm", MakeVectorJson(narrow->place)},
          {"share_below_nozzle", narrow->share}};
}

struct Export {
  const Scene& scene;
  const ParameterSpec& parameters;
  const std::vector<double>& theta;
  PrintFormat format;
  Printer printer;
  std::vector<ToolPart> parts;
  std::vector<std::string> files;  // of the parts
  bool is_written = false;
};

Json MakeJson(const Export& e) {
  Json theta = Json::object();
  for (std::size_t i = 0; i < e.theta.size(); ++i) theta[e.parameters.names[i]] = e.theta[i];
  Json bodies = Json::array();
  for (std::size_t i = 0; i < e.parts.size(); ++i) {
    const ToolPart& part = e.parts[i];
    const PrintCheck& check = part.check;
    Json findings = Json::array();
    for (const PrintFinding& finding : check.findings) {
      findings.push_back({{"kind", finding.kind},
                          {"error", finding.is_error},
                          {"text", finding.text},
                          {"place_mm", finding.place ? MakeVectorJson(*finding.place) : Json()}});
    }
    Json body = {{"body", part.body},
                 {"file", e.is_written ? Json(e.files[i]) : Json()},
                 {"vertices", part.mesh.vertices.size()},
                 {"triangles", part.mesh.triangles.size()}};
    if (!check.HasErrors()) {
      const std::optional<double> mass = FindMass(*FindBody(e.scene, part.body), check.volume);
      body["volume_mm3"] = 1e9 * check.volume;
      body["mass_g"] = mass ? Json(1e3 * *mass) : Json();
      body["extent_mm"] = MakeVectorJson(check.box.sizes());
      body["wall"] = MakeNarrowJson(check.wall);
      body["gap"] = MakeNarrowJson(check.gap);
      body["overhang_share"] = check.overhang;
    }
    body["findings"] = std::move(findings);
    bodies.push_back(std::move(body));
  }
  return {{"scenario", e.scene.name},
          {"theta", std::move(theta)},
          {"format", GetName(e.format)},
          {"unit", e.format == PrintFormat::kGlb ? "m" : "mm"},
          {"nozzle_mm", 1e3 * e.printer.nozzle},
          {"bed_mm", MakeVectorJson(e.printer.bed)},
          {"written", e.is_written},
          {"bodies", std::move(bodies)}};
}

std::string FormatPart(const Export& e, std::size_t i) {
  const ToolPart& part = e.parts[i];
  const PrintCheck& check = part.check;
  std::string text = fmt::format("{}: ", part.body);
  if (check.HasErrors()) {
    text += "cannot be printed\n";
  } else {
    const Vector3d size = 1e3 * check.box.sizes();
    const std::optional<double> mass = FindMass(*FindBody(e.scene, part.body), check.volume);
    text += fmt::format("{:.2f} x {:.2f} x {:.2f} mm, {:.2f} cm^3, {}, {} triangles", size.x(), size.y(), size.z(),
                        1e6 * check.volume,
                        mass ? fmt::format("{:.2f} g", 1e3 * *mass) : "of unknown mass (the scene gives no density)",
                        part.mesh.triangles.size());
    if (check.wall) text += fmt::format(", least wall {:.2f} mm", 1e3 * check.wall->width);
    text += fmt::format("{}\n", e.is_written ? " -> " + CleanText(e.files[i]) : "");
  }
  for (const PrintFinding& finding : check.findings) {
    text += fmt::format("  {}: {}{}\n", finding.is_error ? "error" : "note", finding.text,
                        finding.place ? ", at " + FormatPlace(*finding.place) : "");
  }
  return text;
}

// What --out says, or the scenario's name here; with several bodies their names stand before the ending.
std::string NameFile(const ExportFlags& flags, const Scene& scene, const SceneDesign& design, const std::string& body,
                     PrintFormat format) {
  if (flags.out.empty()) return NameToolFile(design, body, scene.name, format);
  if (design.bodies().size() == 1) return flags.out;
  const fs::path path(flags.out);
  return (path.parent_path() / NameToolFile(design, body, path.stem().string(), format)).string();
}

int RunExport(const ExportFlags& flags) {
  const std::optional<PrintFormat> format = FindPrintFormat(flags.format);
  if (!format) throw UsageError(fmt::format("--format: '{}': stl, 3mf, obj and glb are allowed", flags.format));
  const std::string ending = fmt::format(".{}", GetName(*format));
  if (!flags.out.empty() && !flags.out.ends_with(ending)) {
    throw UsageError(
        fmt::format("--out: '{}': expected a name that ends with {}, as --format says", flags.out, ending));
  }
  const Printer printer{ParseLength(flags.nozzle, "--nozzle"), ParseBed(flags.bed)};
  const RunOrScenario source(flags.path);
  const LoadedScenario scenario = LoadValidScenario(source.config(), flags.overrides);
  const Scene& scene = scenario.parsed.scene;
  if (!scene.design)
    throw UsageError(flags.path + ": design: the scenario designs no body: there is nothing to export");
  const ParameterSpec parameters = MakeProblem(scene, scenario.files).parameters;
  const std::vector<double> theta = ChooseTheta(flags.theta, parameters, source.NameDesigns(parameters.names.size()));
  const SceneDesign design(scene, scenario.files);
  const Eigen::Map<const Eigen::VectorXd> values(theta.data(), design.num_parameters());
  Export e{scene, parameters, theta, *format, printer, CheckTool(design, values, *format, printer), {}};
  std::string refused;
  for (const ToolPart& part : e.parts) {
    e.files.push_back(NameFile(flags, scene, design, part.body, *format));
    if (part.check.HasErrors() && refused.empty()) refused = part.body;
  }
  if (refused.empty()) {
    for (std::size_t i = 0; i < e.parts.size(); ++i) {
      WriteFileAtomically(e.files[i], WritePrintFile(e.parts[i].mesh, *format, e.parts[i].body));
    }
    e.is_written = true;
  }
  if (flags.json) {
    WriteOutput(MakeJsonText(MakeJson(e), 2) + "\n");
  } else {
    for (std::size_t i = 0; i < e.parts.size(); ++i) WriteOutput(FormatPart(e, i));
  }
  if (refused.empty()) return kExitDone;
  WriteComplaint("knap", fmt::format("nothing was written: {} cannot be printed with this theta", refused));
  return kExitFailed;
}

}  // namespace

void AddExportCommand(CLI::App* app, std::function<int()>* command) {
  const auto flags = std::make_shared<ExportFlags>();
  CLI::App* out = app->add_subcommand("export", "Writes the tool as files to print or to look at, and checks them");
  out->add_option("path", flags->path, "scenario file or run directory")->required();
  out->add_option("overrides", flags->overrides, "changes to it, a.b=c");
  out->add_option("--theta", flags->theta,
                  "design: initial, learned, NAME=VALUE,… with the others as by default, or all values v1,v2,… (m, or "
                  "with unit; default: learned of a run, else initial)");
  out->add_option("--format", flags->format, "stl, 3mf, obj (millimetres) or glb (metres, y up); default: stl");
  out->add_option("--out", flags->out,
                  "file (default: SCENARIO.FORMAT here); with several designed bodies one file each, NAME_BODY.FORMAT");
  out->add_option("--nozzle", flags->nozzle, "the printer's, against which walls and gaps are held (default: 0.4 mm)");
  out->add_option("--bed", flags->bed, "width, depth and height that can be printed (default: 250x210x210 mm)");
  out->add_flag("--json", flags->json, "one JSON document on stdout");
  out->callback([flags, command] { *command = [flags] { return RunExport(*flags); }; });
}

}  // namespace knap
