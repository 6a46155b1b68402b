// Scenarios and runs as the commands find them on disk.
#pragma once

#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "coordinator/run_directory/run_directory.h"
#include "lcmtypes/wire/engine_identity.h"
#include "sim/scenarios/scenario_files.h"

namespace knap {

// Of this program: the first digits of the SHA-256 of its file.
std::string FindBuild();

// Throws UsageError with all that is wrong, one line each, unless the scenario is valid.
LoadedScenario LoadValidScenario(const std::filesystem::path& config, std::span<const std::string> overrides);

// Where a new run goes: the folder `out` (see RunDirectory::Create), or one named by time within `home`, to
// which home/latest then leads (what keeps it from doing so is said on stderr).
struct NewRunPlace {
  std::string home;
  std::string out;  // empty: a named one
};

// A new run's folder with what `fill` writes into it. When that fails, the folder is gone again, and does not stand in
// the way of the next try. Throws as CreateRun does.
RunDirectory MakeNewRun(const NewRunPlace& place, const RunInfo& info,
                        const std::function<void(const RunDirectory&)>& fill);

// RunDirectory's Open and Create, with UsageError when the folder is not what they need.
RunDirectory OpenRun(const std::filesystem::path& path);
RunDirectory CreateRun(const std::filesystem::path& path);

// theta.learned of the run's result.json; UsageError when the run has none (it did not finish) or it has not `size`
// values.
std::vector<double> ReadLearnedTheta(const RunDirectory& run, std::size_t size);

// The learned values of all parameters of `names`, in their order, as the run knows them by name. UsageError with
// `option` in front when the run's names are others.
std::vector<double> ReadLearnedByName(const RunDirectory& run, const std::vector<std::string>& names,
                                      const std::string& option);

// A run to go on with. UsageError when this program is not the one that began it (run.json): another build may compute
// other bits, and the run would be neither's.
RunDirectory OpenRunOfThisBuild(const std::filesystem::path& path);

// Writes config.yaml, resolved, and the files it names beside it under the same relative paths, so that the run's
// config.yaml runs on its own; throws UsageError when such a file would overwrite one of the run's own.
void WriteScenario(const LoadedScenario& scenario, const RunDirectory& run);

// Where a run began and what its bits depend on (run.json); method and seed are in config.yaml too.
RunInfo MakeRunInfo(const LoadedScenario& scenario, const std::string& config_hash, const EngineIdentity& engine);

}  // namespace knap
