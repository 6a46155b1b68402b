// The workers a coordinator knows, each as its latest status described it. What they hold is in request_table.h.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "knap/worker_status_t.hpp"
#include "lcmtypes/wire/content_id.h"

namespace knap {

struct KnownWorker {
  std::int64_t instance = 0;
  std::string name;
  std::string host;
  std::int32_t pid = 0;
  std::int64_t run_id = 0;         // the run it works for
  std::int64_t last_sequence = 0;  // of its latest message
  std::int64_t heard_us = 0;       // arrival of its latest message
  std::int64_t status_us = 0;      // arrival of its latest status
  bool silent = false;             // its lease has expired; a sign of life ends this
  bool stalled = false;            // alive, but its computation makes no progress; progress ends this
  std::int64_t stalled_us = 0;     // since when
  std::int64_t progress_us = 0;    // when it last got on: steps, an answer, or new work after idleness
  std::int64_t steps_done = 0;
  std::int64_t finished = 0;
  std::int32_t state = 0;
  ContentId running{};        // by its latest status; zeros after the answer came
  std::int64_t began_us = 0;  // when it began with what it computes now, as far as we can tell
  std::vector<ContentId> unsent_acknowledgements;
  std::vector<ContentId> unsent_cancellations;
};

class WorkerRoster {
 public:
  // The worker that this status describes, updated; null when the status is older than one already seen, or comes from
  // a worker that has departed.
  KnownWorker* Update(const worker_status_t& status, std::int64_t arrival_us);

  KnownWorker* Find(std::int64_t instance);                             // null when unknown
  KnownWorker* FindProcess(const std::string& name, std::int32_t pid);  // null when unknown

  // Forgets a worker for good: what still comes from it is a message from the past.
  void Remove(std::int64_t instance);

  // In ascending order of instance.
  std::map<std::int64_t, KnownWorker>& workers() { return workers_; }
  const std::map<std::int64_t, KnownWorker>& workers() const { return workers_; }

 private:
  std::map<std::int64_t, KnownWorker> workers_;
  std::set<std::int64_t> departed_;
  std::deque<std::int64_t> departed_order_;
};

}  // namespace knap
