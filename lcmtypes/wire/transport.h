// A lossy, unordered message bus as the cluster's state machines see it.
//
// A message may be lost, come twice, late, out of order or with wrong bytes; nothing here promises otherwise. The
// codec (codec.h) refuses wrong bytes, the protocol (docs/protocol.md) copes with the rest.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace knap {

struct Message {
  std::string channel;
  std::vector<std::uint8_t> bytes;
  std::int64_t arrival_us = 0;  // Clock::now_us() when it came off the wire
};

struct TransportCounters {
  std::int64_t published = 0;
  std::int64_t publish_failures = 0;
  std::int64_t received = 0;
  std::int64_t dropped_full_queue = 0;  // arrived, but our bounded queue was full
  std::int64_t dropped_no_memory = 0;   // arrived, but there was no memory to keep it (over tcpq://: the connection)
  std::int64_t dropped_too_large = 0;   // arrived, but larger than any message of ours
};

// One participant's access to the bus; it hears the channels named when it was made. Publish and Receive belong to one
// thread, Wake to any.
class Transport {
 public:
  virtual ~Transport() = default;

  // Sends and forgets. Failure to send is loss, and counted.
  virtual void Publish(const std::string& channel, const std::vector<std::uint8_t>& bytes) = 0;

  // The oldest message waiting; blocks up to timeout_us (0: not at all). Empty on timeout or after Wake.
  virtual std::optional<Message> Receive(std::int64_t timeout_us) = 0;

  // Makes a Receive that blocks now, or else the next one that would, return at once.
  virtual void Wake() = 0;

  virtual TransportCounters counters() const = 0;
};

}  // namespace knap
