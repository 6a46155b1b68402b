// Does a recording of the bus tell what a run's journal holds? Nothing is computed again: every answer of the journal
// must have been asked for and answered in the recording, with the same bits, under digests of the run's key, and every
// request must be the one that its id names.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

#include "coordinator/rollout_service.h"
#include "knap/rollout_request_t.hpp"
#include "knap/rollout_result_t.hpp"
#include "lcmtypes/wire/codec.h"
#include "lcmtypes/wire/content_id.h"
#include "lcmtypes/wire/run_key.h"
#include "lcmtypes/wire/value_parts.h"

namespace knap {

struct RecordingCounters {
  std::int64_t messages = 0;  // on knap's channels
  std::int64_t requests = 0;  // of the run; parts and repeats count
  std::int64_t results = 0;   // of the run; parts and repeats count
  std::int64_t unjournaled = 0;
  RefusalCounters refused;  // damaged, or not signed with the key
};

class RunRecording {
 public:
  using Answer = std::pair<ContentId, RolloutOutcome>;

  // `runs`: the numbers of the run's lives. `journal`: its answers in order. `finished`: nothing may be missing from
  // the journal; a run that goes on, or was killed, may not have written its latest answers.
  RunRecording(const RunKey& key, std::set<std::int64_t> runs, std::vector<Answer> journal, bool finished);

  // The next event of the recording.
  void Add(std::int64_t event, const std::string& channel, const std::vector<std::uint8_t>& bytes);

  // After the last event: the first difference, one line; empty when there is none.
  std::optional<std::string> FindDifference() const;

  const RecordingCounters& counters() const { return counters_; }

 private:
  struct Partial {
    ValueAssembly values;
    bool complete = false;
  };

  // One of the request message's assignments.
  void AddAssignment(std::int64_t event, const rollout_request_t& request, const assignment_t& assignment);
  void AddResult(std::int64_t event, const rollout_result_t& result);
  void Note(std::int64_t event, const std::string& difference);  // the first one stays

  RunKey key_;
  std::set<std::int64_t> runs_;
  std::vector<Answer> journal_;
  bool finished_;
  std::unordered_map<ContentId, std::size_t, ContentIdHash> index_;  // id → place in journal_
  std::map<std::int64_t, std::string> engines_;                      // by worker instance
  std::unordered_map<ContentId, Partial, ContentIdHash> requests_;
  std::map<std::pair<ContentId, std::int64_t>, Partial> results_;  // by id and worker
  std::unordered_set<ContentId, ContentIdHash> answered_;
  std::optional<std::string> difference_;
  RecordingCounters counters_;
};

}  // namespace knap
