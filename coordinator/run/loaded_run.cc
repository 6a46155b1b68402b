#include "coordinator/run/loaded_run.h"

#include <fmt/format.h>

#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <sstream>
#include <stdexcept>
#include <system_error>

#include "coordinator/run/problem_from_scene.h"
#include "coordinator/run/usage_error.h"
#include "coordinator/run_directory/durable_file.h"
#include "lcmtypes/program/standard_streams.h"
#include "lcmtypes/wire/content_id.h"
#include "lcmtypes/wire/text.h"
#include "sim/rollout/check_model.h"

namespace knap {
namespace {

namespace fs = std::filesystem;

// A folder that is not what the command line says is bad usage; a disk that refuses is not.
template <typename Action>
RunDirectory AsUsage(const Action& action) {
  try {
    return action();
  } catch (const std::system_error&) {
    throw;
  } catch (const std::runtime_error& e) {
    throw UsageError(e.what());
  }
}

}  // namespace

std::string FindBuild() { return FormatShort(CalcSha256(ReadFile("/proc/self/exe"))); }

namespace {

struct LearnedTheta {
  std::vector<std::string> names;
  std::vector<double> values;
};

LearnedTheta ReadLearned(const RunDirectory& run) {
  if (!fs::exists(run.result_path())) {
    throw UsageError(
        fmt::format("{}: the run has no result.json: it did not finish; continue it with knap learn --resume {}",
                    run.path().string(), run.path().string()));
  }
  try {
    const nlohmann::json theta = nlohmann::json::parse(ReadFile(run.result_path())).at("theta");
    LearnedTheta learned{theta.at("names").get<std::vector<std::string>>(),
                         theta.at("learned").get<std::vector<double>>()};
    if (learned.names.size() == learned.values.size()) return learned;
    throw UsageError(fmt::format("{}: theta.learned has {} values for {} names", run.result_path().string(),
                                 learned.values.size(), learned.names.size()));
  } catch (const nlohmann::json::exception& e) {
    throw UsageError(fmt::format("{}: {}", run.result_path().string(), e.what()));
  }
}

}  // namespace

std::vector<double> ReadLearnedTheta(const RunDirectory& run, std::size_t size) {
  std::vector<double> theta = ReadLearned(run).values;
  if (theta.size() == size) return theta;
  throw UsageError(fmt::format("{}: theta.learned has {} values; the run's config.yaml has {} parameters",
                               run.result_path().string(), theta.size(), size));
}

std::vector<double> ReadLearnedByName(const RunDirectory& run, const std::vector<std::string>& names,
                                      const std::string& option) {
  const LearnedTheta learned = ReadLearned(run);
  std::map<std::string, double> by_name;
  for (std::size_t i = 0; i < learned.names.size(); ++i) by_name[learned.names[i]] = learned.values[i];
  std::vector<double> values;
  for (const std::string& name : names) {
    const auto found = by_name.find(name);
    if (found == by_name.end()) {
      throw UsageError(fmt::format("{} {}: that run has no parameter '{}', which the scenario has", option,
                                   run.path().string(), name));
    }
    values.push_back(found->second);
    by_name.erase(found);
  }
  if (by_name.empty()) return values;
  throw UsageError(fmt::format("{} {}: that run has a parameter '{}', which the scenario has not", option,
                               run.path().string(), by_name.begin()->first));
}

RunDirectory OpenRun(const fs::path& path) {
  return AsUsage([&] { return RunDirectory::Open(path); });
}

RunDirectory CreateRun(const fs::path& path) {
  return AsUsage([&] { return RunDirectory::Create(path); });
}

RunDirectory MakeNewRun(const NewRunPlace& place, const RunInfo& info,
                        const std::function<void(const RunDirectory&)>& fill) {
  const RunDirectory run =
      place.out.empty() ? RunDirectory::CreateNamed(place.home, info.scenario, info.started) : CreateRun(place.out);
  try {
    fill(run);
  } catch (...) {
    run.Remove();
    throw;
  }
  if (place.out.empty()) {
    if (const std::optional<std::string> obstacle = run.LinkLatest()) WriteComplaint("knap", *obstacle);
  }
  return run;
}

RunDirectory OpenRunOfThisBuild(const fs::path& path) {
  const RunDirectory run = OpenRun(path);
  std::string begun_by;
  try {
    begun_by = nlohmann::json::parse(ReadFile(run.info_path())).at("build").get<std::string>();
  } catch (const nlohmann::json::exception& e) {
    throw UsageError(fmt::format("{}: {}", run.info_path().string(), e.what()));
  }
  const std::string build = FindBuild();
  if (begun_by != build) {
    throw UsageError(
        fmt::format("{}: begun by another build of knap ({}; this one is {}), whose bits may differ: resume it with "
                    "that one, or start a new run with knap learn {}",
                    path.string(), begun_by, build, run.config_path().string()));
  }
  return run;
}

LoadedScenario LoadValidScenario(const fs::path& config, std::span<const std::string> overrides) {
  LoadedScenario scenario = LoadScenario(config, overrides);
  CheckModel(scenario);
  if (!scenario.parsed.ok()) {
    std::istringstream text(scenario.parsed.FormatErrors());
    std::vector<std::string> errors;
    for (std::string line; std::getline(text, line);) errors.push_back(line);
    throw UsageError(errors);
  }
  return scenario;
}

void WriteScenario(const LoadedScenario& scenario, const RunDirectory& run) {
  const std::set<std::string> own = {"config.yaml",  "run.json",      "journal",         "metrics.csv", "rollouts.csv",
                                     "events.jsonl", "trace.json",    "evaluation.json", "result.json", "report.html",
                                     "tool",         "training.json", "policy",          "workers",     "key"};
  for (const auto& [name, bytes] : scenario.files) {
    if (name == kScenarioFileName) continue;
    const std::string first = *fs::path(name).begin();
    if (own.count(first) != 0) {
      throw UsageError(fmt::format("{}: the file '{}' has the name of one that every run writes; give it another",
                                   scenario.parsed.file_name, name));
    }
    fs::create_directories((run.path() / name).parent_path());
    WriteFileAtomically(run.path() / name, bytes);
  }
  run.WriteConfig(scenario.files.at(kScenarioFileName));  // last: it says that the folder is a run
}

RunInfo MakeRunInfo(const LoadedScenario& scenario, const std::string& config_hash, const EngineIdentity& engine) {
  RunInfo info;
  info.version = KNAP_VERSION;
  info.build = FindBuild();
  info.scenario = scenario.parsed.scene.name;
  const LearningOptions options = MakeLearningOptions(scenario.parsed.scene);
  info.method = GetName(options.method);
  info.seed = options.seed;
  info.host = FindHostName();
  info.config_hash = config_hash;
  info.started = std::chrono::system_clock::now();
  // What a run's bits depend on beside the build of knap itself (OpenRunOfThisBuild).
  info.identity = {{"configuration", config_hash},
                   {"engine", engine.name},
                   {"build of knap-worker", engine.build},
                   {"arithmetic (processor or mathematical library)", FormatHex(engine.fingerprint)}};
  return info;
}

}  // namespace knap
