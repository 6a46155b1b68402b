#include "worker/result_store.h"

#include <utility>

namespace knap {

ResultStore::Entry& ResultStore::Add(const ContentId& id, std::vector<rollout_result_t> parts) {
  Entry& entry = entries_[id];
  entry = Entry{std::move(parts), false, 0};
  order_.push_back(id);
  waiting_.push_back(id);
  ++unacknowledged_;
  if (order_.size() > capacity_) {
    const ContentId oldest = order_.front();
    order_.pop_front();
    Acknowledge(oldest);
    entries_.erase(oldest);
  }
  return entry;
}

ResultStore::Entry* ResultStore::Find(const ContentId& id) {
  const auto found = entries_.find(id);
  return found == entries_.end() ? nullptr : &found->second;
}

void ResultStore::Acknowledge(const ContentId& id) {
  Entry* entry = Find(id);
  if (entry == nullptr || entry->acknowledged) return;
  entry->acknowledged = true;
  --unacknowledged_;
  while (!waiting_.empty()) {
    const Entry* front = Find(waiting_.front());
    if (front != nullptr && !front->acknowledged) break;
    waiting_.pop_front();
  }
}

void ResultStore::AcknowledgeAll() {
  for (auto& [id, entry] : entries_) entry.acknowledged = true;
  waiting_.clear();
  unacknowledged_ = 0;
}

std::vector<ContentId> ResultStore::FindDue(std::int64_t sent_before_us, std::size_t limit) const {
  std::vector<ContentId> due;
  for (const ContentId& id : waiting_) {
    if (due.size() >= limit) break;
    const auto found = entries_.find(id);
    if (found == entries_.end() || found->second.acknowledged) continue;
    if (found->second.sent_at_us < sent_before_us) due.push_back(id);
  }
  return due;
}

}  // namespace knap
