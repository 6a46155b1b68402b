#include "lcmtypes/wire/clock.h"

#include <chrono>

namespace knap {
namespace {

template <typename TimePoint>
std::int64_t CountMicroseconds(TimePoint t) {
  return std::chrono::duration_cast<std::chrono::microseconds>(t.time_since_epoch()).count();
}

}  // namespace

std::int64_t SteadyClock::now_us() const { return CountMicroseconds(std::chrono::steady_clock::now()); }

std::int64_t SteadyClock::wall_us() const { return CountMicroseconds(std::chrono::system_clock::now()); }

double ReadSteadySeconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace knap
