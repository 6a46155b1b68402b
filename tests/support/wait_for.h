// Waiting for an event whose time is unknown. The limit ends what hangs; no outcome depends on how fast a machine is.
#pragma once

#include <chrono>
#include <functional>
#include <thread>

namespace knap {

inline constexpr std::chrono::seconds kWaitLimit{600};

// False when the condition has not come true within kWaitLimit.
inline bool WaitFor(const std::function<bool()>& condition) {
  const auto end = std::chrono::steady_clock::now() + kWaitLimit;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return true;
}

}  // namespace knap
