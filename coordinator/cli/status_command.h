// knap status: who is on the bus and how far they are.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>

namespace knap {

// Adds the subcommand to `app`; when it is parsed, `*command` becomes what is to be run.
void AddStatusCommand(CLI::App* app, std::function<int()>* command);

}  // namespace knap
