#include "coordinator/run_directory/run_directory.h"

#include <ctime>
#include <stdexcept>
#include <utility>

#include "coordinator/run_directory/durable_file.h"

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

// A link cannot be changed in place; renaming a new one over it leaves no moment without a link.
void ReplaceLink(const fs::path& link, const std::string& target) {
  fs::path temporary = link;
  temporary += "." + target;  // no other run has this name
  fs::create_directory_symlink(target, temporary);
  fs::rename(temporary, link);
}

}  // namespace

std::string MakeRunName(const std::string& scenario, std::chrono::system_clock::time_point started) {
  return scenario + "-" + FormatUtc(started, "%Y%m%dT%H%M%SZ");
}

RunDirectory RunDirectory::Create(const fs::path& path) {
  if (fs::exists(path) && !(fs::is_directory(path) && fs::is_empty(path))) {
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
  ReplaceLink(runs / "latest", name);
  return RunDirectory(runs / name);
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
  const nlohmann::ordered_json json = {{"version", info.version},
                                       {"build", info.build},
                                       {"scenario", info.scenario},
                                       {"method", info.method},
                                       {"seed", info.seed},
                                       {"host", info.host},
                                       {"config_hash", info.config_hash},
                                       {"started_utc", FormatUtc(info.started, "%Y-%m-%dT%H:%M:%SZ")}};
  WriteFileAtomically(info_path(), MakeJsonText(json, 2) + "\n");
}

void RunDirectory::WriteResult(const ResultDocument& document) const {
  // Both texts first: a number that JSON cannot hold must leave no file behind. result.json last: it says "done".
  const std::string result = MakeJsonText(MakeResultJson(document), 2) + "\n";
  const std::string evaluation =
      MakeJsonText({{"initial", MakeEvaluationJson(document.test_initial, document.has_success)},
                    {"learned", MakeEvaluationJson(document.test_learned, document.has_success)}},
                   2) +
      "\n";
  WriteFileAtomically(evaluation_path(), evaluation);
  WriteFileAtomically(result_path(), result);
}

}  // namespace knap
