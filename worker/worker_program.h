// The program around an engine: command line, LCM, signals, the reactor's loop.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "worker/engine.h"

namespace knap {

// One that a program may run, by its name.
struct EngineChoice {
  std::string name;
  std::function<std::unique_ptr<Engine>()> make;
};

// knap-worker [--engine NAME] [--lcm-url URL] [--key FILE] [--name NAME]
// Secures the standard streams, then works until its run says stop or SIGTERM or SIGINT comes, or until it lacks
// something (memory, descriptors, processor time), which it tells its coordinator and stderr. Returns the exit code: 0
// done, 1 failed while running or lacked something, 2 bad usage. Without --name the worker is called HOST-PID, without
// --engine it runs the first of `engines`; a program that has one alone has no such flag.
int RunWorkerProgram(int argc, char** argv, const std::vector<EngineChoice>& engines);

}  // namespace knap
