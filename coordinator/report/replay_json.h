// Rollouts of a run's test, simulated again for the report's page.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <vector>

#include "coordinator/report/report_source.h"
#include "sim/rollout/rollout.h"

namespace knap {

// Which variations are worth a look, the most telling first: those on which the learned tool fails, the largest loss
// first; then those on which it succeeds where the initial one does not; then the others, in their order.
std::vector<std::size_t> ChooseReplays(const ReportSource& source, bool has_success);

// One recorded rollout. Series of poses and forces are packed as singles; of many contacts those with the largest
// forces are kept.
nlohmann::ordered_json MakeReplayJson(const ReportedTest& test, std::size_t variation, const RecordedRollout& rollout,
                                      bool has_success);

}  // namespace knap
