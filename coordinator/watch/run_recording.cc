#include "coordinator/watch/run_recording.h"

#include <fmt/format.h>

#include "coordinator/dispatch/answer_cache.h"
#include "knap/worker_status_t.hpp"
#include "lcmtypes/wire/channels.h"
#include "lcmtypes/wire/request_values.h"

namespace knap {

RunRecording::RunRecording(const RunKey& key, std::set<std::int64_t> runs, std::vector<Answer> journal, bool finished)
    : key_(key), runs_(std::move(runs)), journal_(std::move(journal)), finished_(finished) {
  for (std::size_t i = 0; i < journal_.size(); ++i) index_.emplace(journal_[i].first, i);
}

void RunRecording::Note(std::int64_t event, const std::string& difference) {
  if (!difference_) difference_ = fmt::format("event {}: {}", event, difference);
}

void RunRecording::Add(std::int64_t event, const std::string& channel, const std::vector<std::uint8_t>& bytes) {
  if (channel.compare(0, 5, "KNAP_") != 0) return;
  ++counters_.messages;
  if (channel == kWorkerStatusChannel) {
    if (const auto status = Open<worker_status_t>(bytes, key_, &counters_.refused)) {
      engines_[status->sender] = status->engine;
    }
  } else if (channel == kResultChannel) {
    const auto result = Open<rollout_result_t>(bytes, key_, &counters_.refused);
    if (result && runs_.count(result->run_id) != 0) AddResult(event, *result);
  } else if (channel.compare(0, kRequestPrefix.size(), kRequestPrefix) == 0) {
    const auto request = Open<rollout_request_t>(bytes, key_, &counters_.refused);
    if (!request || runs_.count(request->run_id) == 0) return;
    for (const assignment_t& assignment : request->assignments) AddAssignment(event, *request, assignment);
  }
}

void RunRecording::AddAssignment(std::int64_t event, const rollout_request_t& request, const assignment_t& assignment) {
  ++counters_.requests;
  const ContentId id = MakeId(assignment.id);
  const std::int64_t total = CountValues(assignment);
  if (total > kMaxValues) {
    Note(event, fmt::format("request {} announces {} values", FormatHex(id), total));
    return;
  }
  const auto size = static_cast<std::int32_t>(total);
  Partial& partial = requests_.try_emplace(id, Partial{ValueAssembly(size)}).first->second;
  if (!partial.values.Add(size, assignment.first_value, assignment.values)) {
    Note(event, fmt::format("a part of request {} does not belong to the others", FormatHex(id)));
    return;
  }
  if (partial.complete || !partial.values.IsComplete()) return;
  partial.complete = true;
  const auto engine = engines_.find(request.receiver);
  if (engine == engines_.end()) {
    Note(event, fmt::format("request {} goes to a worker of which no status was recorded", FormatHex(id)));
    return;
  }
  const RequestValues asked(assignment, partial.values.values());
  const ContentId expected = CalcRequestId({engine->second, MakeId(request.scenario), asked.theta, asked.controls,
                                            asked.reference, asked.variation, assignment.gradient != 0, asked.nodes});
  if (expected != id) {
    Note(event, fmt::format("request {} asks what would be request {}", FormatHex(id), FormatHex(expected)));
  }
}

void RunRecording::AddResult(std::int64_t event, const rollout_result_t& result) {
  ++counters_.results;
  const ContentId id = MakeId(result.id);
  const auto known = index_.find(id);
  if (known == index_.end()) {
    ++counters_.unjournaled;
    if (finished_ && result.status == rollout_result_t::kOk) {
      Note(event, fmt::format("worker {} answers request {}, of which the journal knows nothing", result.worker,
                              FormatHex(id)));
    }
    return;
  }
  const std::string difference = result.status == rollout_result_t::kOk
                                     ? DescribeDifference(result, journal_[known->second].second)
                                     : fmt::format("it fails with '{}'", result.error);
  if (!difference.empty()) {
    Note(event, fmt::format("worker {} answers request {} otherwise than the journal: {}", result.worker, FormatHex(id),
                            difference));
    return;
  }
  Partial& partial =
      results_.try_emplace({id, result.sender}, Partial{ValueAssembly(result.gradient_size)}).first->second;
  partial.values.Add(result.gradient_size, result.first_value, result.values);
  if (partial.values.IsComplete()) answered_.insert(id);
}

std::optional<std::string> RunRecording::FindDifference() const {
  if (difference_) return difference_;
  for (std::size_t i = 0; i < journal_.size(); ++i) {
    const ContentId& id = journal_[i].first;
    const auto request = requests_.find(id);
    if (request == requests_.end() || !request->second.complete) {
      return fmt::format("answer {} of the journal: request {} is not in the recording", i + 1, FormatHex(id));
    }
    if (answered_.count(id) == 0) {
      return fmt::format("answer {} of the journal: no result for request {} is in the recording", i + 1,
                         FormatHex(id));
    }
  }
  return std::nullopt;
}

}  // namespace knap
