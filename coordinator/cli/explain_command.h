// `knap explain`: where a run's requests are or were, why they were sent again, how long they took.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>

namespace knap {

// Adds the subcommand to `app`; when it is parsed, `*command` becomes what is to be run.
void AddExplainCommand(CLI::App* app, std::function<int()>* command);

}  // namespace knap
