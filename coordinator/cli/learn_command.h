// knap learn: learns a tool on a cluster and leaves a run directory behind [README.md].
#pragma once

#include <CLI/CLI.hpp>
#include <functional>

namespace knap {

// Adds the subcommand to `app`; when it is parsed, `*command` becomes what is to be run.
void AddLearnCommand(CLI::App* app, std::function<int()>* command);

}  // namespace knap
