// A run's answers across crashes: what the cluster answered is on the disk before the optimizer sees it and before a
// worker may forget it, and a resumed run gets it from there. Learning is a pure function of the answers, so a resumed
// run goes on to the same bits.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

#include "coordinator/dispatch/dispatcher.h"
#include "coordinator/rollout_service.h"
#include "coordinator/run_directory/journal.h"
#include "lcmtypes/wire/content_id.h"

namespace knap {

struct JournaledAnswer {
  ContentId id{};
  RolloutOutcome outcome;
};

// Bytes, one answer after the other, integers and doubles (IEEE 754 bits) little endian: 32 bytes id, then loss,
// worst_residual, loss_error, penetration, largest_force, forward_s, gradient_s as doubles, then subdivided_steps,
// contact_onsets, steps as uint32, flags as uint32 (bit 0 success, 1 finite, 2 converged, 3 gradient_reliable), length
// of distrust as uint32, distrust, length of the gradient as uint32, gradient as doubles.
std::string EncodeAnswers(std::span<const JournaledAnswer> answers);
// Throws std::runtime_error when the bytes are not what EncodeAnswers makes.
std::vector<JournaledAnswer> DecodeAnswers(std::string_view bytes);

// The dispatcher behind a journal.
class JournaledService : public RolloutService {
 public:
  // `payloads`: the journal's of an earlier life, whose answers are never asked for again, however many they are. Both
  // others must outlive the service, which takes the dispatcher's hooks on_result and on_commit.
  JournaledService(Dispatcher* dispatcher, Journal* journal, std::vector<std::string> payloads);

  // As Dispatcher::Evaluate; what was answered is durable when this returns or throws.
  std::vector<RolloutOutcome> Evaluate(std::span<const RolloutQuery> queries) override;

  // Called with every answer that the cluster computed.
  void set_on_answer(std::function<void(const RolloutReport&)> hook) { on_answer_ = std::move(hook); }

  std::int64_t total() const { return total_; }  // queries so far
  std::int64_t distinct() const { return static_cast<std::int64_t>(distinct_.size()); }
  // Queries answered so far, whether by the cluster or from memory.
  std::int64_t answered() const { return finished_ + static_cast<std::int64_t>(current_); }
  std::int64_t from_journal() const { return static_cast<std::int64_t>(earlier_.size()); }  // answers that were there

 private:
  void Flush();

  Dispatcher* dispatcher_;
  Journal* journal_;
  // As bytes, decoded when they are wanted: an outcome as a structure takes several times as much.
  const std::vector<std::string> payloads_;
  std::unordered_map<ContentId, std::string_view, ContentIdHash> earlier_;  // within payloads_
  std::vector<JournaledAnswer> pending_;
  std::unordered_set<ContentId, ContentIdHash> distinct_;
  std::int64_t total_ = 0;
  std::int64_t finished_ = 0;  // queries of calls that returned
  std::size_t current_ = 0;    // answers that came during the present call
  std::function<void(const RolloutReport&)> on_answer_;
};

}  // namespace knap
