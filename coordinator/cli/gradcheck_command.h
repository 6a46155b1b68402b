// knap gradcheck: are the rollouts' gradients those of their losses?
#pragma once

#include <CLI/CLI.hpp>
#include <functional>

namespace knap {

// Adds the subcommand to `app`; when it is parsed, `*command` becomes what is to be run.
void AddGradcheckCommand(CLI::App* app, std::function<int()>* command);

}  // namespace knap
