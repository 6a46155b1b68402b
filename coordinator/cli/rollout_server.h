// knap rollout --server: rollouts for a program that asks for them line by line, whatever its language.
//
// Every line, either way, is one JSON document. First comes
//
//   {"server": 1, "scenario": …, "loss_unit": …, "parameters": [{"name", "unit", "lower", "upper", "initial"}, …],
//    "variation": [{"key", "nominal"}, …]}
//
// and then an answer to each line read, in their order: what `knap rollout --json` prints, with the `id` that was asked
// with, or {"id": …, "error": "…"}. A line asks for one rollout:
//
//   id               anything, is given back                                                  (null)
//   theta            [SI numbers], {name: SI number, …} or a text as --theta takes it         (as --theta has it)
//   reference_theta  likewise; the distillation loss against the trajectory of this design    (task loss)
//   variation        [SI numbers], {key: SI number, …}, or the number of a test variation     (the file's own values)
//   gradient         whether it is wanted                                                     (true)
//
// What objects do not name stays as by default. It ends when stdin does. docs/python.md has an example.
#pragma once

#include "coordinator/cli/theta_choice.h"
#include "coordinator/learning/problem.h"
#include "sim/rollout/rollout.h"
#include "sim/scenarios/scenario_files.h"

namespace knap {

// Throws std::system_error when stdout does not take an answer. `model` is of this scenario.
void ServeRollouts(const LoadedScenario& scenario, const ParameterSpec& parameters, const NamedDesigns& designs,
                   RolloutModel* model);

}  // namespace knap
