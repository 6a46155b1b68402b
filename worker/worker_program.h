// The program around an engine: command line, LCM, signals, the reactor's loop.
#pragma once

#include <memory>

#include "worker/engine.h"

namespace knap {

// knap-worker [--lcm-url URL] [--key FILE] [--name NAME]
// Secures the standard streams, then works until its run says stop or SIGTERM or SIGINT comes, or until it lacks
// something (memory, descriptors, processor time), which it tells its coordinator and stderr. Returns the exit code: 0
// done, 1 failed while running or lacked something, 2 bad usage. Without --name the worker is called HOST-PID.
int RunWorkerProgram(int argc, char** argv, std::unique_ptr<Engine> engine);

}  // namespace knap
