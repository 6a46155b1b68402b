// knap landscape: two parameters take every value of a grid; what does the loss do?
#pragma once

#include <CLI/CLI.hpp>
#include <functional>

namespace knap {

// Adds the subcommand to `app`; when it is parsed, `*command` becomes what is to be run.
void AddLandscapeCommand(CLI::App* app, std::function<int()>* command);

}  // namespace knap
