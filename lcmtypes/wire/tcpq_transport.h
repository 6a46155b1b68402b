// The Transport over tcpq://, where multicast does not pass: one TCP connection to a relay (tcpq_relay.h, or LCM's own
// Java TCPService), without Nagle's delay.
//
// It speaks the protocol itself: liblcm's client closes its socket in one thread while another publishes, so that a
// message can land in whatever file gets the number next; it blocks without end on a frozen relay, allocates by any
// length it is told, and resolves no names (docs/decisions/0009_only_our_own_code_receives.md).
//
// A lost connection is made again, with growing pauses; what is published meanwhile is lost, and counted.
#pragma once

#include <atomic>
#include <cstddef>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "lcmtypes/wire/clock.h"
#include "lcmtypes/wire/message_queue.h"
#include "lcmtypes/wire/tcpq_stream.h"
#include "lcmtypes/wire/transport.h"

namespace knap {

class TcpqTransport : public Transport {
 public:
  // Hears `channels`. Throws std::invalid_argument for a wrong URL, std::runtime_error when no relay answers within 2
  // s. `clock` must outlive the transport.
  TcpqTransport(const std::string& url, const std::vector<std::string>& channels, const Clock* clock);
  ~TcpqTransport() override;
  TcpqTransport(const TcpqTransport&) = delete;
  TcpqTransport& operator=(const TcpqTransport&) = delete;

  void Publish(const std::string& channel, const std::vector<std::uint8_t>& bytes) override;
  std::optional<Message> Receive(std::int64_t timeout_us) override { return queue_.Receive(timeout_us); }
  void Wake() override { queue_.Wake(); }
  TransportCounters counters() const override { return queue_.counters(); }

 private:
  std::string Connect();  // returns why it failed; empty when the relay has greeted
  void Serve();           // until the connection is lost or the transport stops
  bool ReadAll(TcpqReader* reader);
  bool Flush();  // sends what the socket takes; false when the connection is lost. Precondition: send_mutex_ is held.
  void Disconnect();
  // Waits for the socket (-1: for nothing), at most so long; false when the transport stops or time is over.
  bool WaitFor(int fd, short events, int timeout_ms);
  void Run();

  const TcpqAddress address_;
  const std::vector<std::string> channels_;
  const Clock* const clock_;
  MessageQueue queue_;
  std::atomic<bool> stopping_{false};
  int wake_fd_ = -1;       // an eventfd: stop, or bytes to send
  std::mutex send_mutex_;  // guards all below; only the thread changes fd_
  int fd_ = -1;
  std::string unsent_;
  std::thread thread_;
};

}  // namespace knap
