// A scenario made ready to be learned, before it touches disk or network; and what makes its journal its own.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "coordinator/learning/learning_options.h"
#include "coordinator/learning/problem.h"
#include "coordinator/run/cluster_session.h"
#include "coordinator/run_directory/journal.h"
#include "coordinator/run_directory/run_directory.h"
#include "sim/rollout/rollout.h"
#include "sim/scenarios/scenario_files.h"

namespace knap {

struct PreparedScenario {
  LoadedScenario scenario;
  Problem problem;
  LearningOptions options;
  std::unique_ptr<RolloutModel> model;
  std::string config_hash;  // of the scenario with its files, hexadecimal
};

// Throws UsageError with all that is wrong, one line each.
PreparedScenario PrepareScenario(const std::filesystem::path& config, std::span<const std::string> overrides);

// The run's journal, made when there is none: a run killed before that has asked nothing yet. Throws UsageError when it
// is another run's, std::system_error when the disk refuses.
Journal::Opened OpenRunJournal(const RunDirectory& run, const RunIdentity& identity);

// What theta means, beside the run's own files:
// - the designed meshes, each in its body's frame, as STL and 3MF in millimetres: tool/NAME.stl where there is one,
//   else tool/NAME_BODY.stl; nothing for a scenario that designs none;
// - a policy's weights as a file that a scenario may start from, policy/NAME.txt; nothing without a policy.
void WriteTools(const RolloutModel& model, const std::vector<double>& theta, const RunDirectory& run,
                const std::string& name);

}  // namespace knap
