// A policy's weights from demonstrations [paper, appendix, Flipping]: a scenario's policy is taken away, what it drives
// gets open-loop controls, these are learned with a design of their own in each of many variations, and the network
// learns to do, where it sees what was seen then, what was done then.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "coordinator/imitation/demonstrations.h"
#include "coordinator/imitation/imitation.h"
#include "sim/rollout/rollout.h"
#include "sim/scenarios/scenario_files.h"

namespace knap {

// The scenario with open-loop controls in place of its policy: the same actuators and intervals, tanh, every control 0
// at first and from -3 to 3; design and controls are learned. Throws std::invalid_argument with one line for a scenario
// without a policy, and for one with open-loop controls beside it, which nobody would imitate.
LoadedScenario MakeOpenLoopScenario(const LoadedScenario& scenario);

// What the policy would have seen, and was done, at the start of every interval of the demonstrations that succeeded,
// one after the other. `open_loop` is of MakeOpenLoopScenario; rollouts are simulated anew, in this process.
Examples CollectExamples(const Policy& policy, RolloutModel& open_loop, std::span<const Demonstration> demonstrations);

// Start of the imitation: a pure function of the seed, whatever file the policy starts from elsewhere.
std::vector<double> MakeImitationStart(const Policy& policy, std::uint64_t seed);

// The policy's rollout in the variation of a demonstration, with the first values of theta as the design.
struct PolicyTrial {
  double loss = 0.0;
  bool success = false;
};
PolicyTrial TryPolicy(RolloutModel& closed_loop, std::span<const double> weights, std::span<const double> design,
                      std::span<const double> variation);

}  // namespace knap
