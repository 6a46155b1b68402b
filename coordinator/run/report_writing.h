// report.html: of a run, from its own answers and rollouts simulated again; of a study; of two runs.
#pragma once

#include <filesystem>
#include <functional>

#include "coordinator/run_directory/run_directory.h"
#include "sim/rollout/rollout.h"
#include "sim/scenarios/scenario_files.h"

namespace knap {

// `run` has ended: it has its result.json. `progress` as MakeReportPage calls it. Throws as MakeReportPage does, and
// std::system_error where the disk refuses.
void WriteReport(const LoadedScenario& scenario, const RunDirectory& run, RolloutModel& model,
                 const std::filesystem::path& path, const std::function<void(int done, int total)>& progress);

// Of a study that has ended, from its study.json and the files of its runs. Throws UsageError where it has not.
void WriteStudyReport(const LoadedScenario& scenario, const RunDirectory& study, const std::filesystem::path& path);

// Of two runs that have ended, of scenarios with the same parameters. Throws UsageError where they are not.
void WriteComparison(const LoadedScenario& scenario, const RunDirectory& first, const RunDirectory& second,
                     const std::filesystem::path& path);

}  // namespace knap
