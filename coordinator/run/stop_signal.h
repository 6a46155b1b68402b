// Ctrl-C and SIGTERM as a flag that the program looks at where it can stop in order.
#pragma once

#include <atomic>

namespace knap {

// From now on the first SIGINT or SIGTERM sets the flag and a second one ends the program at once (its workers die with
// it). The flag lives as long as the program.
const std::atomic<bool>& CatchStopSignals();

}  // namespace knap
