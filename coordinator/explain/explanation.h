// A run's requests in words, for `knap explain`: where one is or was, why it was sent again, how long it took.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "coordinator/explain/live_run.h"
#include "coordinator/explain/request_origin.h"
#include "coordinator/explain/run_record.h"

namespace knap {

struct ExplainedRun {
  std::string path;  // as the user named it
  RunRecord record;
  std::optional<RunNames> names;  // none: the scenario cannot be read
  std::string nameless;           // and why not, one line
  std::optional<LiveRun> live;    // none: it has ended, or is not heard
  std::string silence;            // and what is known then of where it is now, one line
};

// Ids of requests that begin with these lower-case hexadecimal digits, in order: all 64 digits, or 12 where the run's
// files have no more of one that was never answered. As few as tell them apart are enough.
std::vector<std::string> FindRequests(const ExplainedRun& run, const std::string& digits);

// The whole run: how many requests, which were sent again and why, who was lost, what took long, what waits now.
// Lines with their ends.
std::string ExplainRun(const ExplainedRun& run);

// One request, with an id of FindRequests.
std::string ExplainRequest(const ExplainedRun& run, const std::string& id);

}  // namespace knap
