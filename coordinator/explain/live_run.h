// What the bus tells of a run that goes on: how much is open, and where.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "coordinator/watch/cluster_view.h"
#include "lcmtypes/wire/content_id.h"

namespace knap {

struct LiveWorker {
  std::string name, host;
  std::vector<ContentId> held;  // what it has taken and not answered, the running one first
  bool computes = false;        // the first of them
  double step_fraction = 0.0;   // of that one, in [0, 1]
};

struct LiveRun {
  std::int64_t open = 0;  // requests without an answer
  int workers = 0;        // that take requests now
  std::vector<LiveWorker> heard;
};

// Empty when nothing was heard of a run of this number that goes on.
std::optional<LiveRun> FindLiveRun(const ClusterView& view, std::int64_t run_id);

}  // namespace knap
