// report.html of a run in its folder, from the run's own answers and rollouts simulated again.
#pragma once

#include <filesystem>

#include "coordinator/progress/stderr_progress.h"
#include "coordinator/run_directory/run_directory.h"
#include "sim/rollout/rollout.h"
#include "sim/scenarios/scenario_files.h"

namespace knap {

// `run` has ended: it has its result.json. `shown` tells how far it is. Throws as MakeReportPage does, and
// std::system_error where the disk refuses.
void WriteReport(const LoadedScenario& scenario, const RunDirectory& run, RolloutModel& model,
                 const std::filesystem::path& path, StderrProgress* shown);

}  // namespace knap
