// knap evaluate: how good designs are on variations they never saw.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>

namespace knap {

// Adds the subcommand to `app`; when it is parsed, `*command` becomes what is to be run.
void AddEvaluateCommand(CLI::App* app, std::function<int()>* command);

}  // namespace knap
