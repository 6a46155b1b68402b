// knap export: the tool as files for printers and viewers, checked before they are written.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>

namespace knap {

// Adds the subcommand to `app`; when it is parsed, `*command` becomes what is to be run.
void AddExportCommand(CLI::App* app, std::function<int()>* command);

}  // namespace knap
