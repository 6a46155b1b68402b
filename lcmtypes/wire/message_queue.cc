#include "lcmtypes/wire/message_queue.h"

#include <chrono>
#include <utility>

#include "lcmtypes/wire/channels.h"

namespace knap {
namespace {

constexpr std::size_t kQueueCapacity = 16384;  // messages: at most 21 MB

}  // namespace

void MessageQueue::Put(const std::string& channel, const std::uint8_t* data, std::size_t size,
                       std::int64_t arrival_us) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (size > kMaxMessageSize) {
      ++counters_.dropped_too_large;
      return;
    }
    if (queue_.size() >= kQueueCapacity) {
      ++counters_.dropped_full_queue;
      return;
    }
    ++counters_.received;
    queue_.push_back({channel, {data, data + size}, arrival_us});
  }
  arrived_.notify_one();
}

std::optional<Message> MessageQueue::Receive(std::int64_t timeout_us) {
  std::unique_lock<std::mutex> lock(mutex_);
  const auto ready = [this] { return !queue_.empty() || woken_; };
  if (timeout_us > 0) {
    arrived_.wait_until(lock, std::chrono::steady_clock::now() + std::chrono::microseconds(timeout_us), ready);
  }
  if (queue_.empty()) {
    woken_ = false;
    return std::nullopt;
  }
  Message message = std::move(queue_.front());
  queue_.pop_front();
  return message;
}

void MessageQueue::Wake() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    woken_ = true;
  }
  arrived_.notify_one();
}

void MessageQueue::CountPublished(bool sent) {
  const std::lock_guard<std::mutex> lock(mutex_);
  ++(sent ? counters_.published : counters_.publish_failures);
}

void MessageQueue::CountNoMemory() {
  const std::lock_guard<std::mutex> lock(mutex_);
  ++counters_.dropped_no_memory;
}

TransportCounters MessageQueue::counters() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return counters_;
}

}  // namespace knap
