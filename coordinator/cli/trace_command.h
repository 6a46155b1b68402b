// knap trace: a run's timeline for a viewer of traces.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>

namespace knap {

// Adds the subcommand to `app`; when it is parsed, `*command` becomes what is to be run.
void AddTraceCommand(CLI::App* app, std::function<int()>* command);

}  // namespace knap
