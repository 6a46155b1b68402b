// Answers by content id: what is asked again is not computed again, and what is answered again must be answered alike.
#pragma once

#include <cstddef>
#include <deque>
#include <string>
#include <unordered_map>

#include "coordinator/rollout_service.h"
#include "knap/rollout_result_t.hpp"
#include "lcmtypes/wire/content_id.h"

namespace knap {

class AnswerCache {
 public:
  struct Answer {
    RolloutOutcome outcome;
    std::string worker;  // who computed it
  };

  // Beyond `capacity` answers the oldest are forgotten.
  explicit AnswerCache(std::size_t capacity) : capacity_(capacity) {}

  const Answer* Find(const ContentId& id) const;  // null when unknown
  void Insert(const ContentId& id, Answer answer);

 private:
  std::size_t capacity_;
  std::unordered_map<ContentId, Answer, ContentIdHash> answers_;
  std::deque<ContentId> order_;
};

// The outcome that a complete answer tells; `gradient` are the values of all its parts.
RolloutOutcome MakeOutcome(const rollout_result_t& result, const std::vector<double>& gradient);

// The first field in which one part of an answer differs, bit for bit, from an outcome: its name and both values; empty
// when they agree. Wall times may differ.
std::string DescribeDifference(const rollout_result_t& part, const RolloutOutcome& outcome);

}  // namespace knap
