// How the program ends [README.md].
#pragma once

#include <functional>

namespace knap {

enum ExitCode : int {
  kExitDone = 0,
  kExitFailed = 1,  // while running
  kExitUsage = 2,   // bad usage or config
  kExitNoWorkers = 4,
  kExitInterrupted = 130,  // after saving
};

// Runs a command and turns what it throws into a message on stderr and an exit code: UsageError and
// std::invalid_argument 2, NoWorkers 4, Interrupted 130, anything else 1.
int RunCommand(const std::function<int()>& command);

}  // namespace knap
