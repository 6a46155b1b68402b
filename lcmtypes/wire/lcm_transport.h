// The Transport over LCM: udpm:// on one machine or a LAN, tcpq:// where multicast does not pass.
//
// One thread of its own takes messages from liblcm and puts them, stamped with their arrival, into a bounded queue;
// when that is full new ones are dropped and counted. On udpm the socket carries a kernel filter (socket_filter.h).
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <lcm/lcm-cpp.hpp>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "lcmtypes/wire/clock.h"
#include "lcmtypes/wire/transport.h"

namespace knap {

class LcmTransport : public Transport {
 public:
  // Hears `channels` (exact names, without characters special to regular expressions). Throws std::runtime_error or
  // std::invalid_argument with one clear line when the URL is wrong or the network does not work. `clock` must outlive
  // the transport.
  LcmTransport(const std::string& url, const std::vector<std::string>& channels, const Clock* clock);
  ~LcmTransport() override;
  LcmTransport(const LcmTransport&) = delete;
  LcmTransport& operator=(const LcmTransport&) = delete;

  void Publish(const std::string& channel, const std::vector<std::uint8_t>& bytes) override;
  std::optional<Message> Receive(std::int64_t timeout_us) override;
  void Wake() override;
  TransportCounters counters() const override;

  // What the kernel granted as receive buffer [byte]; 0 when unknown (tcpq).
  int receive_buffer_size() const { return receive_buffer_size_; }

 private:
  void SubscribeAll(const std::vector<std::string>& channels);
  void SubscribeFiltered(int port, const std::vector<std::string>& channels);
  void DrainIntoQueue();
  static void Store(const lcm_recv_buf_t* buffer, const char* channel, void* self);

  const Clock* clock_;
  lcm::LCM lcm_;
  int receive_buffer_size_ = 0;
  std::atomic<bool> stopping_{false};
  int stop_fd_ = -1;  // an eventfd that wakes the thread to see stopping_
  std::mutex publish_mutex_;
  mutable std::mutex mutex_;  // guards all below
  std::condition_variable arrived_;
  std::deque<Message> queue_;
  bool woken_ = false;
  TransportCounters counters_;
  std::thread receiver_;
};

}  // namespace knap
