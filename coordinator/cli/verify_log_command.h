// knap verify-log: does a recording of the bus tell what a run's journal holds?
#pragma once

#include <CLI/CLI.hpp>
#include <functional>

namespace knap {

// Adds the subcommand to `app`; when it is parsed, `*command` becomes what is to be run.
void AddVerifyLogCommand(CLI::App* app, std::function<int()>* command);

}  // namespace knap
