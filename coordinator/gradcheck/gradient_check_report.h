// A gradient check as one JSON document and as text for a person.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "coordinator/gradcheck/gradient_check.h"
#include "coordinator/learning/problem.h"

namespace knap {

// passed, failures, checked, agreed, flagged, unflagged_disagreements, quarantined (= flagged), nonconverged,
// zero_gradient, draws, evaluated, max_rel_error, tolerance, seed, and rollouts: for each its draw, theta, variation,
// loss, verdict, rel_error, certificate, and parameters: a row each with name, analytic, difference, rel_error, step,
// plateau_steps. All SI. Numbers that could not be had are null.
nlohmann::ordered_json MakeGradientCheckJson(const GradientCheckReport& report, const Problem& problem,
                                             const GradientCheckOptions& options);

// "draw 3: agreed, relative error 1.2e-09", "draw 4: flagged, gradient not reliable", for the moment at which it is
// known.
std::string FormatVerdict(const CheckedRollout& rollout);

// Counts, the worst rollouts with their worst parameters, what failed. `rollout_command` is what runs one rollout of
// the same scenario, such as "knap rollout configs/pushing.yaml"; each listed rollout shows it with its own arguments.
std::string FormatGradientCheck(const GradientCheckReport& report, const Problem& problem,
                                const GradientCheckOptions& options, const std::string& rollout_command);

}  // namespace knap
