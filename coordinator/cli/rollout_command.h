// knap rollout: one rollout in this process, for a look at a single case.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>

namespace knap {

// Adds the subcommand to `app`; when it is parsed, `*command` becomes what is to be run.
void AddRolloutCommand(CLI::App* app, std::function<int()>* command);

}  // namespace knap
