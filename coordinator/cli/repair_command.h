// knap repair: makes a run with a damaged journal one that can be resumed.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>

namespace knap {

// Adds the subcommand; when the command line names it, *command runs it and returns the exit code.
void AddRepairCommand(CLI::App* app, std::function<int()>* command);

}  // namespace knap
