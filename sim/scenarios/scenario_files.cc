#include "sim/scenarios/scenario_files.h"

#include <fmt/format.h>

#include <cerrno>
#include <fstream>
#include <set>
#include <sstream>
#include <stdexcept>
#include <system_error>

#include "sim/scenarios/dump_scene.h"

namespace knap {
namespace {

// The bytes of a regular file; else what the system says went wrong.
struct FileBytes {
  std::string bytes;
  std::string error;
};

FileBytes ReadFile(const std::filesystem::path& path) {
  std::error_code code;
  const std::filesystem::file_status status = std::filesystem::status(path, code);
  if (code) return {"", code.message()};
  if (status.type() != std::filesystem::file_type::regular) return {"", "not a regular file"};
  std::ifstream stream(path, std::ios::binary);
  if (!stream) return {"", std::generic_category().message(errno)};
  std::ostringstream bytes;
  bytes << stream.rdbuf();
  // An empty file sets failbit on `bytes`; only `stream` tells of a failed read.
  if (stream.bad()) return {"", "the read failed"};
  return {bytes.str(), ""};
}

}  // namespace

std::filesystem::path FindScenarioFile(const std::filesystem::path& folder, const std::string& path) {
  namespace fs = std::filesystem;
  const fs::path beside = folder / path;
  std::error_code ignored;
  if (fs::exists(beside, ignored)) return beside;
  // Upwards from what stands before the component.
  fs::path above, within;
  for (const fs::path& component : fs::path(path)) {
    if (within.empty() && component != "library") {
      above /= component;
    } else {
      within /= component;
    }
  }
  if (within.empty()) return beside;
  const fs::path start = fs::absolute(folder / above, ignored).lexically_normal();
  for (fs::path at = start; at.has_relative_path(); at = at.parent_path()) {
    if (fs::exists(at.parent_path() / within, ignored)) return at.parent_path() / within;
  }
  return beside;
}

LoadedScenario LoadScenario(const std::filesystem::path& config, std::span<const std::string> overrides) {
  LoadedScenario loaded;
  const FileBytes text = ReadFile(config);
  if (!text.error.empty()) {
    loaded.parsed.file_name = config.string();
    loaded.parsed.log.Fail("", {}, "cannot be read: " + text.error);
    return loaded;
  }
  const auto read = [&config](const std::string& path) {
    const std::filesystem::path at = FindScenarioFile(config.parent_path(), path);
    FileBytes file = ReadFile(at);
    if (!file.error.empty()) throw std::runtime_error(file.error);
    return IncludedText{at.string(), std::move(file.bytes)};
  };
  loaded.parsed = ParseScene(text.bytes, config.string(), overrides, read);
  for (const FileReference& reference : loaded.parsed.files) {
    const std::filesystem::path path = FindScenarioFile(config.parent_path(), reference.path);
    FileBytes file = ReadFile(path);
    if (!file.error.empty()) {
      loaded.parsed.log.Report(reference.field,
                               fmt::format("the file {} cannot be read: {}", path.string(), file.error));
      continue;
    }
    loaded.files[reference.path] = std::move(file.bytes);
  }
  if (loaded.parsed.ok()) loaded.files[kScenarioFileName] = DumpScene(loaded.parsed.scene);
  return loaded;
}

std::map<std::string, std::string> ListTaskFiles(const LoadedScenario& scenario) {
  std::map<std::string, std::string> files = scenario.files;
  files[kScenarioFileName] = DumpTask(scenario.parsed.scene);
  return files;
}

Scene ParseScenarioFiles(const std::map<std::string, std::string>& files) {
  const auto text = files.find(kScenarioFileName);
  if (text == files.end()) throw std::runtime_error(fmt::format("the scenario has no {}", kScenarioFileName));
  ParseResult parsed = ParseScene(text->second, kScenarioFileName);
  if (!parsed.ok()) {
    const std::string errors = parsed.FormatErrors();
    throw std::runtime_error(errors.substr(0, errors.find('\n')));
  }
  std::set<std::string> unnamed;
  for (const auto& [name, bytes] : files) unnamed.insert(name);
  unnamed.erase(kScenarioFileName);
  for (const FileReference& reference : parsed.files) {
    if (!files.contains(reference.path)) {
      throw std::runtime_error(
          fmt::format("the scenario lacks the file '{}' that its {} names", reference.path, reference.field));
    }
    unnamed.erase(reference.path);
  }
  if (!unnamed.empty()) {
    throw std::runtime_error(fmt::format("the scenario carries a file '{}' that it does not name", *unnamed.begin()));
  }
  return std::move(parsed.scene);
}

}  // namespace knap
