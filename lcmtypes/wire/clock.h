// Time as the cluster's state machines see it; tests replace it by a simulated clock.
//
// Nothing that a run computes depends on it: it decides only when to send again and whom to believe dead.
#pragma once

#include <cstdint>

namespace knap {

class Clock {
 public:
  virtual ~Clock() = default;
  // Microseconds since some fixed instant; never goes back. Leases and timeouts use this alone.
  virtual std::int64_t now_us() const = 0;
  // Microseconds since 1970 (UTC): the `utime` of messages, for display alone.
  virtual std::int64_t wall_us() const = 0;
};

// The machine's steady clock. Thread-safe.
class SteadyClock : public Clock {
 public:
  std::int64_t now_us() const override;
  std::int64_t wall_us() const override;
};

// Of the same, for what reports how long it took [s].
double ReadSteadySeconds();

}  // namespace knap
