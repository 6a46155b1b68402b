// knap train-policy: the weights of a scenario's policy from demonstrations.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>

namespace knap {

// When it was chosen, *command runs it and returns the exit code.
void AddTrainPolicyCommand(CLI::App* app, std::function<int()>* command);

}  // namespace knap
