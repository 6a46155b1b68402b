// knap cage: a cage around a mesh, and what may be learned of it as text to paste into a scenario.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>

namespace knap {

// Adds the subcommand to `app`; when it is parsed, `*command` becomes what is to be run.
void AddCageCommand(CLI::App* app, std::function<int()>* command);

}  // namespace knap
