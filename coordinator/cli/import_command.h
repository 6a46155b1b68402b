// knap import: turns a robot in URDF into a file that scenarios include.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>

namespace knap {

// Adds the subcommand; when the command line names it, *command runs it and returns the exit code.
void AddImportCommand(CLI::App* app, std::function<int()>* command);

}  // namespace knap
