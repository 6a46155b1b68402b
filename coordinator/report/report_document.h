// report.html of a run: everything that came out of it on one page that opens from disk [docs/architecture.md].
//
// The page's text and scripts are in page/, what they show is one JSON document within it, made here from the run's
// files. Replays are simulated here and stand beside the run's own answers, so that one sees that they are the same.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "coordinator/report/report_source.h"

namespace knap {

// How many rollouts a page of so many test variations has, at most: fewer where it would be too large.
int CountReplays(std::int64_t variations);

// `progress`: called with the replays done and their number; may be empty. A replay says in "same_bits" whether its
// loss and success are those of the run's own answer. Throws std::runtime_error where the run's files are not readable,
// and what RolloutModel throws.
std::string MakeReportPage(const ReportSource& source, const std::function<void(int done, int total)>& progress);

}  // namespace knap
