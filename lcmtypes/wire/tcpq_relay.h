// A relay for tcpq://: every message a client publishes goes to all clients that subscribed to its channel.
//
// One thread, nothing shared, no blocking: a client that does not read loses messages (counted) and holds up nobody.
// It knows no run key and judges no message; receivers do. What a stranger can do to it is bounded: clients, bytes a
// client, subscriptions a client.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "lcmtypes/wire/tcpq_stream.h"

namespace knap {

struct TcpqRelayCounters {
  std::int64_t clients = 0;    // that ever connected
  std::int64_t relayed = 0;    // messages taken
  std::int64_t delivered = 0;  // messages put into a client's way
  std::int64_t dropped = 0;    // for clients that did not read
  std::int64_t refused = 0;    // connections that broke the protocol or were too many
};

class TcpqRelay {
 public:
  // Listens at this IPv4 address; port 0 takes a free one. Throws std::runtime_error naming the address.
  TcpqRelay(const std::string& host, int port);
  ~TcpqRelay();
  TcpqRelay(const TcpqRelay&) = delete;
  TcpqRelay& operator=(const TcpqRelay&) = delete;

  int port() const { return port_; }

  // Relays until the flag is set, at which it looks five times a second.
  void Run(const std::atomic<bool>& stop);

  const TcpqRelayCounters& counters() const { return counters_; }

 private:
  struct Client;

  void Accept();
  bool Read(Client* client);  // false: close it
  void Relay(const TcpqMessage& message);
  static bool Flush(Client* client);

  int listener_ = -1;
  int port_ = 0;
  std::vector<std::unique_ptr<Client>> clients_;
  TcpqRelayCounters counters_;
};

}  // namespace knap
