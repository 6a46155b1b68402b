// `knap report RUN`: report.html, a page on which one sees what came out of a run.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>

namespace knap {

void AddReportCommand(CLI::App* app, std::function<int()>* command);

}  // namespace knap
