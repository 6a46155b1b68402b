// The bounded queue between a transport's receiving thread and the one thread that takes messages from it; when it is
// full new messages are dropped and counted.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <mutex>
#include <optional>
#include <string>

#include "lcmtypes/wire/transport.h"

namespace knap {

class MessageQueue {
 public:
  // By the receiving thread. A message larger than kMaxMessageSize is dropped and counted.
  void Put(const std::string& channel, const std::uint8_t* data, std::size_t size, std::int64_t arrival_us);

  // As Transport::Receive, Wake and counters. CountPublished and CountNoMemory add to the latter.
  std::optional<Message> Receive(std::int64_t timeout_us);
  void Wake();
  void CountPublished(bool sent);
  void CountNoMemory();
  TransportCounters counters() const;

 private:
  mutable std::mutex mutex_;  // guards all below
  std::condition_variable arrived_;
  std::deque<Message> queue_;
  bool woken_ = false;
  TransportCounters counters_;
};

}  // namespace knap
