#include "coordinator/run_directory/run_directory.h"

#include <ctime>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "coordinator/run_directory/durable_file.h"
#include "coordinator/run_directory/json_text.h"

namespace knap {
namespace {

namespace fs = std::filesystem;

std::string FormatUtc(std::chrono::system_clock::time_point time, const char* format) {
  const std::time_t seconds = std::chrono::system_clock::to_time_t(time);
  std::tm utc{};
  gmtime_r(&seconds, &utc);
  char text[32];
  return std::string(text, std::strftime(text, sizeof text, format, &utc));
}

// Whether a crash cut off the making of a run here: run.json is the first file of one, and config.yaml the last.
bool IsCutOffBeginning(const fs::path& path) {
  return (fs::exists(path / "run.json") || fs::exists(path / "run.json.tmp")) && !fs::exists(path / "config.yaml");
}

}  // namespace

std::string MakeRunName(const std::string& scenario, std::chrono::system_clock::time_point started) {
  return scenario + "-" + FormatUtc(started, "%Y%m%dT%H%M%SZ");
}

RunDirectory RunDirectory::Create(const fs::path& path) {
  if (fs::exists(path) && !(fs::is_directory(path) && (fs::is_empty(path) || IsCutOffBeginning(path)))) {
    throw std::runtime_error(path.string() +
                             ": exists already and is not an empty folder; choose another, or resume it");
  }
  fs::create_directories(path);
  return RunDirectory(path);
}

RunDirectory RunDirectory::CreateNamed(const fs::path& runs, const std::string& scenario,
                                       std::chrono::system_clock::time_point started) {
  fs::create_directories(runs);
  const std::string base = MakeRunName(scenario, started);
  std::string name = base;
  for (int number = 2; !fs::create_directory(runs / name); ++number) name = base + "-" + std::to_string(number);
  return RunDirectory(runs / name);
}

void RunDirectory::Remove() const noexcept {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

std::optional<std::string> RunDirectory::LinkLatest() const {
  const fs::path link = path_.parent_path() / "latest";
  std::error_code error;
  const fs::file_status found = fs::symlink_status(link, error);
  if (fs::exists(found) && !fs::is_symlink(found)) {
    return link.string() + " is not a link and stays as it is; the run is in " + path_.string();
  }
  // A link cannot be changed in place; renaming a new one over it leaves no moment without a link.
  fs::path temporary = link;
  temporary += ".";
  temporary += path_.filename();  // no other run has this name
  fs::create_directory_symlink(path_.filename(), temporary, error);
  if (!error) {
    fs::rename(temporary, link, error);
    std::error_code ignored;
    if (error) fs::remove(temporary, ignored);
  }
  if (!error) return std::nullopt;
  return link.string() + " cannot be made a link to " + path_.string() + ": " + error.message();
}

RunDirectory RunDirectory::Open(const fs::path& path) {
  RunDirectory run(path);
  if (!fs::is_regular_file(run.config_path())) {
    throw std::runtime_error(path.string() + ": no run directory (it holds no config.yaml)");
  }
  return run;
}

void RunDirectory::WriteConfig(const std::string& yaml) const { WriteFileAtomically(config_path(), yaml); }

void RunDirectory::WriteRunInfo(const RunInfo& info) const {
  nlohmann::ordered_json identity = nlohmann::ordered_json::object();
  for (const auto& [name, value] : info.identity) identity[name] = value;
  nlohmann::ordered_json json = {{"version", info.version},
                                 {"build", info.build},
                                 {"scenario", info.scenario},
                                 {"method", info.method},
                                 {"seed", info.seed},
                                 {"host", info.host},
                                 {"config_hash", info.config_hash},
                                 {"started_utc", FormatUtc(info.started, "%Y-%m-%dT%H:%M:%SZ")},
                                 {"identity", identity}};
  if (!info.started_from.empty()) json["started_from"] = info.started_from;
  WriteFileAtomically(info_path(), MakeJsonText(json, 2) + "\n");
}

RunIdentity RunDirectory::ReadIdentity() const try {
  RunIdentity identity;
  const auto json = nlohmann::ordered_json::parse(ReadFile(info_path()));
  for (const auto& [name, value] : json.at("identity").items()) identity.emplace_back(name, value.get<std::string>());
  return identity;
} catch (const nlohmann::json::exception& e) {
  throw std::runtime_error(info_path().string() + ": " + e.what());
}

void RunDirectory::WriteResult(const ResultDocument& document) const {
  // Both texts first: a number that JSON cannot hold must leave no file behind. result.json last: it says "done".
  const std::string result = MakeJsonText(MakeResultJson(document), 2) + "\n";
  const std::string evaluation = MakeJsonText(MakeEvaluationsJson(document), 2) + "\n";
  WriteFileAtomically(evaluation_path(), evaluation);
  WriteFileAtomically(result_path(), result);
}

}  // namespace knap
