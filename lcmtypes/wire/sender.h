// One participant's voice: stamps every message with sender, sequence number, run and wall time, seals it, publishes
// it.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

#include "lcmtypes/wire/clock.h"
#include "lcmtypes/wire/codec.h"
#include "lcmtypes/wire/run_key.h"
#include "lcmtypes/wire/transport.h"

namespace knap {

class Sender {
 public:
  // `sender`: the nonce of this worker instance or of this run. Transport and clock must outlive it.
  Sender(std::int64_t sender, const RunKey& key, Transport* transport, const Clock* clock)
      : sender_(sender), key_(key), transport_(transport), clock_(clock) {}

  template <typename T>
  void Publish(std::string_view channel, std::int64_t run_id, T message) {
    message.utime = clock_->wall_us();
    message.run_id = run_id;
    message.sender = sender_;
    message.sequence = ++sequence_;
    transport_->Publish(std::string(channel), Seal(std::move(message), key_));
  }

 private:
  std::int64_t sender_;
  RunKey key_;
  Transport* transport_;
  const Clock* clock_;
  std::int64_t sequence_ = 0;
};

}  // namespace knap
