// What a bystander knows of the runs and workers on a bus from their status messages alone.
//
// Pure state: messages and their arrival times go in, nothing goes out to the bus.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "knap/run_status_t.hpp"
#include "knap/worker_status_t.hpp"
#include "lcmtypes/wire/codec.h"
#include "lcmtypes/wire/run_key.h"
#include "lcmtypes/wire/transport.h"

namespace knap {

// [s] since something was heard; 0 where that is still to come by this clock.
double CalcAge(std::int64_t heard_us, std::int64_t now_us);

struct WatchedRun {
  run_status_t status{};
  std::int64_t heard_us = 0;  // arrival of its latest status
};

struct WatchedWorker {
  worker_status_t status{};
  std::int64_t heard_us = 0;                                        // arrival of its latest status
  std::deque<std::pair<std::int64_t, std::int64_t>> finished_then;  // (arrival, finished) of the last few seconds

  double CalcRate() const;  // answers a second over these; 0 with fewer than two statuses
};

class ClusterView {
 public:
  // What a transport for a bystander must hear.
  static std::vector<std::string> ListChannels();

  explicit ClusterView(const RunKey& key) : key_(key) {}

  // Statuses older than the latest from the same sender are ignored; what is not signed with the key is counted.
  void Handle(const Message& message);

  // Forgets runs and workers of which nothing was heard for 30 s.
  void Forget(std::int64_t now_us);

  const std::map<std::int64_t, WatchedRun>& runs() const { return runs_; }           // by run id
  const std::map<std::int64_t, WatchedWorker>& workers() const { return workers_; }  // by instance
  const RefusalCounters& refusals() const { return refusals_; }

 private:
  RunKey key_;
  std::map<std::int64_t, WatchedRun> runs_;
  std::map<std::int64_t, WatchedWorker> workers_;
  RefusalCounters refusals_;
};

}  // namespace knap
