// A worker's memory of its answers: kept and sent again until acknowledged, and after that for a while, so that a
// repeated request is answered without computing it again.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <unordered_map>
#include <vector>

#include "knap/rollout_result_t.hpp"
#include "lcmtypes/wire/content_id.h"

namespace knap {

class ResultStore {
 public:
  struct Entry {
    std::vector<rollout_result_t> parts;  // without run, sequence and digest, which are set when they are sent
    bool acknowledged = false;
    std::int64_t sent_at_us = 0;
  };

  // Beyond `capacity` answers the oldest are forgotten, acknowledged or not: whoever still wants one asks again.
  explicit ResultStore(std::size_t capacity) : capacity_(capacity) {}

  Entry& Add(const ContentId& id, std::vector<rollout_result_t> parts);
  Entry* Find(const ContentId& id);  // null when unknown
  void Acknowledge(const ContentId& id);

  // Up to `limit` ids not acknowledged and last sent before `sent_before_us`, oldest answers first.
  std::vector<ContentId> FindDue(std::int64_t sent_before_us, std::size_t limit) const;

  std::size_t unacknowledged() const { return unacknowledged_; }

  // Marks every answer as acknowledged: the run that wanted them is gone.
  void AcknowledgeAll();

 private:
  std::size_t capacity_;
  std::size_t unacknowledged_ = 0;
  std::unordered_map<ContentId, Entry, ContentIdHash> entries_;
  std::deque<ContentId> order_;    // all entries, oldest first
  std::deque<ContentId> waiting_;  // those not acknowledged, oldest first; may hold acknowledged ones until swept
};

}  // namespace knap
