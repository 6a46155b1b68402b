// knap validate: everything that is wrong with a scenario, at once; or the reference of the format.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>

namespace knap {

// Adds the subcommand to `app`; when it is parsed, `*command` becomes what is to be run.
void AddValidateCommand(CLI::App* app, std::function<int()>* command);

}  // namespace knap
