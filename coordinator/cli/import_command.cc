#include "coordinator/cli/import_command.h"

#include <fmt/format.h>

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <system_error>

#include "coordinator/cli/exit_codes.h"
#include "coordinator/import/urdf_import.h"
#include "coordinator/run/usage_error.h"
#include "coordinator/run_directory/durable_file.h"
#include "lcmtypes/program/standard_streams.h"
#include "lcmtypes/wire/text.h"

namespace knap {
namespace {

namespace fs = std::filesystem;

struct ImportFlags {
  std::string urdf;
  std::string out;
  std::string follow;
};

// Where a mesh lies that a URDF names: package://NAME/… is looked for beside and above the file, as packages lie.
std::optional<fs::path> FindMesh(const fs::path& urdf, const std::string& uri) {
  const fs::path folder = fs::absolute(urdf).parent_path();
  const auto is_file = [](const fs::path& path) {
    std::error_code code;
    return fs::is_regular_file(path, code);
  };
  const std::string package = "package://";
  const std::string file = "file://";
  if (!uri.starts_with(package)) {
    const fs::path path = uri.starts_with(file) ? fs::path(uri.substr(file.size())) : folder / uri;
    return is_file(path) ? std::optional(path) : std::nullopt;
  }
  const fs::path within = uri.substr(package.size());
  for (fs::path at = folder;; at = at.parent_path()) {
    if (is_file(at / within)) return at / within;
    // The package's own folder may have another name than the package.
    if (const fs::path inside = within.lexically_relative(*within.begin()); is_file(at / inside)) return at / inside;
    if (at == at.parent_path()) return std::nullopt;
  }
}

int RunImport(const ImportFlags& flags) {
  std::string text;
  try {
    text = ReadFile(flags.urdf);
  } catch (const std::system_error& error) {
    throw UsageError(error.what());
  }
  UrdfOptions options;
  options.path_file = flags.follow;
  options.read_mesh = [&](const std::string& uri) -> std::optional<std::string> {
    const std::optional<fs::path> path = FindMesh(flags.urdf, uri);
    return path ? std::optional(ReadFile(*path)) : std::nullopt;
  };
  ImportedRobot robot;
  try {
    robot = ImportUrdf(text, options);
  } catch (const std::runtime_error& error) {
    throw UsageError(fmt::format("{}: {}", flags.urdf, error.what()));
  }
  const fs::path out = flags.out.empty() ? fs::path(robot.name + ".yaml") : fs::path(flags.out);
  const std::string source = fs::path(flags.urdf).filename().string();
  std::map<fs::path, std::string> files{{out, FormatImport(robot, CleanText(source), out.filename().string())}};
  for (const auto& [name, bytes] : robot.meshes) files[out.parent_path() / name] = bytes;
  for (const auto& [path, bytes] : files) {
    if (fs::exists(path)) {
      throw UsageError(
          fmt::format("{}: is there already; choose another name with --out, or remove it", path.string()));
    }
  }
  for (const auto& [path, bytes] : files) {
    if (path.has_parent_path()) fs::create_directories(path.parent_path());
    WriteFileAtomically(path, bytes);
  }
  std::string said;
  for (const std::string& remark : robot.remarks) said += CleanText(remark) + "\n";
  said += fmt::format("{}: {} bodies, {} joints, {} meshes\n", CleanText(out.string()), robot.bodies.size(),
                      robot.body_of_joint.size(), robot.meshes.size());
  said += fmt::format("a scenario in the same folder takes it over with\n  include: [{{file: {}, name: {}}}]\n",
                      CleanText(out.filename().string()), robot.name);
  WriteOutput(said);
  return kExitDone;
}

}  // namespace

void AddImportCommand(CLI::App* app, std::function<int()>* command) {
  const auto flags = std::make_shared<ImportFlags>();
  // `import` itself is a word of the language's, which formatters stumble over.
  CLI::App* subcommand = app->add_subcommand("import", "Turns a robot in URDF into a file that scenarios include");
  subcommand->add_option("urdf", flags->urdf, "the robot")->required();
  subcommand->add_option("--out", flags->out, "file to write, its meshes beside it (default: the robot's name, .yaml)");
  subcommand->add_option("--follow", flags->follow,
                         "CSV file beside it with a column for each joint: joints follow these instead of being free");
  subcommand->callback([flags, command] { *command = [flags] { return RunImport(*flags); }; });
}

}  // namespace knap
