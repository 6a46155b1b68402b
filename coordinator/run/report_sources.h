// What reports of a run are made from: its scenario, its test's variations, its answers to them.
#pragma once

#include <string>
#include <unordered_map>
#include <vector>

#include "coordinator/learning/problem.h"
#include "coordinator/report/report_source.h"
#include "coordinator/rollout_service.h"
#include "coordinator/run_directory/run_directory.h"
#include "lcmtypes/wire/content_id.h"
#include "sim/rollout/rollout.h"
#include "sim/scenarios/scenario_files.h"

namespace knap {

using Answers = std::unordered_map<ContentId, RolloutOutcome, ContentIdHash>;

// With the first so many variations of the test, and no designs yet. All arguments but the number must outlive it.
ReportSource MakeReportSource(const LoadedScenario& scenario, const RunDirectory& run, const Problem& problem,
                              RolloutModel& model, std::int64_t variations);

// A design on the source's variations: the ids of its requests and, where there are any, their answers. `task`: the
// scenario's id.
ReportedTest MakeReportedTest(const ReportSource& source, const ContentId& task, const std::string& name,
                              std::vector<double> theta, const Answers& answers);

}  // namespace knap
