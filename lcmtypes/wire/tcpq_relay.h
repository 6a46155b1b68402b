// A relay for tcpq://: every message a client publishes goes to all clients that subscribed to its channel.
//
// One thread, nothing shared, no blocking: a client that does not read loses messages (counted) and holds up nobody.
// It knows no run key and judges no message; receivers do. What a stranger can do to it is bounded: clients, bytes and
// subscriptions a client, and the bytes held for all clients together. When these come near their bound, the clients
// for which most is held are closed. Without a descriptor for a new client it waits a while before it tries again.
#pragma once

#include <poll.h>

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "lcmtypes/wire/tcpq_stream.h"

namespace knap {

struct TcpqRelayCounters {
  std::int64_t clients = 0;          // that ever connected
  std::int64_t relayed = 0;          // messages taken
  std::int64_t delivered = 0;        // messages put into a client's way
  std::int64_t dropped = 0;          // for clients that did not read, or for want of memory
  std::int64_t refused = 0;          // connections that broke the protocol or were too many
  std::int64_t hungry = 0;           // connections closed because most memory was held for them
  std::int64_t accept_failures = 0;  // the system had no descriptor or no memory for a connection
  std::int64_t most_held = 0;        // [byte] for all clients together
};

class TcpqRelay {
 public:
  static constexpr std::size_t kMemory = 256 << 20;  // [byte]

  // Listens at this IPv4 address; port 0 takes a free one. `memory`, 1 MiB or more: what may be held for all clients
  // together [byte]: what they do not read, their unfinished messages, their subscriptions. Throws std::runtime_error
  // naming the address.
  TcpqRelay(const std::string& host, int port, std::size_t memory = kMemory);
  ~TcpqRelay();
  TcpqRelay(const TcpqRelay&) = delete;
  TcpqRelay& operator=(const TcpqRelay&) = delete;

  int port() const { return port_; }

  // Relays until the flag is set, at which it looks five times a second.
  void Run(const std::atomic<bool>& stop);

  const TcpqRelayCounters& counters() const { return counters_; }

 private:
  struct Client;

  void Wait();
  void Accept();
  bool Read(Client* client);  // false: close it
  void Relay(const TcpqMessage& message);
  bool Flush(Client* client);
  void Account(Client* client);  // after its buffers have changed
  void CloseHungriest(std::vector<bool>* lost);
  void Close(const std::vector<bool>& lost);

  const std::size_t memory_;
  std::size_t held_ = 0;
  int listener_ = -1;
  int port_ = 0;
  std::vector<std::unique_ptr<Client>> clients_;
  std::vector<pollfd> waiting_;  // the listener, then the clients
  std::chrono::steady_clock::time_point accept_after_;
  TcpqRelayCounters counters_;
};

}  // namespace knap
