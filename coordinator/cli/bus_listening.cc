#include "coordinator/cli/bus_listening.h"

#include <algorithm>
#include <atomic>
#include <optional>

#include "coordinator/run/stop_signal.h"

namespace knap {

void ListenUntil(std::int64_t until_us, Transport* transport, const Clock& clock, ClusterView* view) {
  const std::atomic<bool>& stop = CatchStopSignals();
  while (!stop && clock.now_us() < until_us) {
    const std::optional<Message> message =
        transport->Receive(std::clamp<std::int64_t>(until_us - clock.now_us(), 0, 100'000));
    if (message) view->Handle(*message);
  }
}

}  // namespace knap
