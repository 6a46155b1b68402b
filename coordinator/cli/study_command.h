// knap study: all methods, many seeds, one pool of workers.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>

namespace knap {

void AddStudyCommand(CLI::App* app, std::function<int()>* command);

}  // namespace knap
