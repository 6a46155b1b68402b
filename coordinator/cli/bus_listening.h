// Commands that listen to a bus and say nothing there.
#pragma once

#include <cstdint>

#include "coordinator/watch/cluster_view.h"
#include "lcmtypes/wire/clock.h"
#include "lcmtypes/wire/transport.h"

namespace knap {

// Shows the view what is heard until this time, or a signal to stop.
void ListenUntil(std::int64_t until_us, Transport* transport, const Clock& clock, ClusterView* view);

}  // namespace knap
