// What a run's files tell of its requests: who was given which when, and what became of it.
//
// rollouts.csv has a row for every answer. events.jsonl has what was out of the ordinary: workers that were lost with
// requests in their hands (worker_gone), second copies (requests_copied), lost messages (requests_resent) and what was
// open when the run was broken off (requests_dropped). Runs of earlier versions have counts of some of these alone.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "coordinator/run_directory/run_directory.h"
#include "coordinator/run_directory/run_logs.h"

namespace knap {

// A start of the run, or a resumption.
struct RecordedLife {
  double begin_s = 0.0;                   // seconds of work on the run, as all times here
  double end_s = 0.0;                     // of the last that is known of it
  std::int64_t answers_from_journal = 0;  // that were there when it began
  std::string end{};                      // "done", "interrupted", "failed"; empty: it tells no end
  std::string error{};                    // of a failed one
};

// Something that befell a request. `why` is a name of TroubleKind: a worker that held it is gone (died, faulted,
// silent, stopping, lacking, stuck, elsewhere), straggler, message_lost, or dropped.
struct RequestSetback {
  std::size_t life = 0;  // index
  double time_s = 0.0;
  std::string id;  // its first digits
  std::string why;
  std::string worker;     // who held it; empty: it waited
  int attempt = 0;        // which of the times in this life it was given to a worker, from 1
  double held_s = 0.0;    // since then
  std::string copy_to{};  // straggler: who got the copy
  int copy_attempt = 0;   // which of the times this is
};

struct GoneWorker {
  double time_s = 0.0;
  std::string worker, host, why;
  std::size_t held = 0;  // requests
};

struct RunRecord {
  std::string scenario, method, host, started, engine;  // of run.json; empty where it does not tell
  std::int64_t seed = 0;
  std::vector<RecordedLife> lives;
  std::vector<RolloutRow> answers;  // in order
  std::vector<RequestSetback> setbacks;
  std::vector<GoneWorker> gone;
  std::vector<std::pair<double, std::string>> remarks;  // time, and a line about a worker that was refused or left
  // From counts, which all versions have.
  std::int64_t reissued = 0, copied = 0, workers_lost = 0;
  // False: the run began with a version that wrote no setbacks.
  bool tells_why = false;

  // Index of the life in which something at this time happened; 0 where none is told.
  std::size_t FindLife(double time_s) const;
};

// Throws std::system_error when run.json or rollouts.csv cannot be read; lines that are damaged are left out.
RunRecord ReadRunRecord(const RunDirectory& run);

// The designs that the run has tried, for telling whose request is whose: (batch, evaluation) and all d values, from
// metrics.csv. Empty when there is none, or its columns are not `names`.
struct TriedDesign {
  int batch = 0, evaluation = 0;
  std::vector<double> theta;
};
std::vector<TriedDesign> ReadTriedDesigns(const RunDirectory& run, const std::vector<std::string>& names);

}  // namespace knap
