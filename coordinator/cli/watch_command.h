// knap watch: a run that goes on, as a page for a browser.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>

namespace knap {

void AddWatchCommand(CLI::App* app, std::function<int()>* command);

}  // namespace knap
