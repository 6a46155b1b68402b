// The Transport over LCM's UDP multicast, udpm://, on one machine or a LAN.
//
// liblcm sends; a socket of our own receives, with a kernel filter (socket_filter.h) from before it is bound, so that
// no fragment and no crafted datagram ever meets liblcm's receiving code. One thread takes messages from it and puts
// them, stamped with their arrival, into a bounded queue.
#pragma once

#include <atomic>
#include <lcm/lcm-cpp.hpp>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "lcmtypes/wire/clock.h"
#include "lcmtypes/wire/message_queue.h"
#include "lcmtypes/wire/transport.h"

namespace knap {

class LcmTransport : public Transport {
 public:
  // Hears `channels`, by their exact names. Throws std::runtime_error or
  // std::invalid_argument with one clear line when the URL is wrong or the network does not work. `clock` must outlive
  // the transport.
  LcmTransport(const std::string& url, const std::vector<std::string>& channels, const Clock* clock);
  ~LcmTransport() override;
  LcmTransport(const LcmTransport&) = delete;
  LcmTransport& operator=(const LcmTransport&) = delete;

  void Publish(const std::string& channel, const std::vector<std::uint8_t>& bytes) override;
  std::optional<Message> Receive(std::int64_t timeout_us) override { return queue_.Receive(timeout_us); }
  void Wake() override { queue_.Wake(); }
  TransportCounters counters() const override { return queue_.counters(); }

  // What the kernel granted as receive buffer [byte].
  int receive_buffer_size() const { return receive_buffer_size_; }

 private:
  void DrainIntoQueue();
  void TakeDatagrams();

  const Clock* clock_;
  lcm::LCM lcm_;
  int receive_fd_ = -1;  // none when there are no channels to hear
  int receive_buffer_size_ = 0;
  std::atomic<bool> stopping_{false};
  int stop_fd_ = -1;  // an eventfd that wakes the thread to see stopping_
  std::mutex publish_mutex_;
  MessageQueue queue_;
  std::thread receiver_;
};

}  // namespace knap
