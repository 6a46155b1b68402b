// Demonstrations: how a task is done in each of many variations, one by one [paper, appendix, Flipping]. Every
// variation gets a design and open-loop controls of its own, learned from the initial ones with the simulator's
// gradients.
//
// Where that fails, what was learned elsewhere may be a better start: from the second round on, each variation that has
// not succeeded begins again from the nearest one that has, by the distance of their numbers over the numbers' ranges,
// ties by index. A round sees the successes of the rounds before it alone, so that nothing depends on which variation
// is ready first.
//
// All variations are worked on at the same time, one evaluation each in turn (coordinator/study/shared_service.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "coordinator/learning/learning_options.h"
#include "coordinator/learning/problem.h"
#include "coordinator/rollout_service.h"

namespace knap {

struct DemonstrationOptions {
  int variations = 100;     // tried: 0 … variations-1 of the stream kDemonstrations; >= 1
  std::uint64_t seed = 0;   // of that stream
  int rounds = 1;           // at most; the last is the first without a new success; >= 1
  bool has_success = true;  // of the task; where it has no success test, whatever is trusted is a success
  // Of each variation's own learning; method, numbers of variations, validation, budget and seed are replaced.
  LearningOptions learning{};
};

struct Demonstration {
  std::vector<double> variation{};
  std::vector<double> theta{};  // design, then controls
  double loss = 0.0;            // of theta; not finite where nothing could be learned
  bool success = false;         // of theta; false where the rollout is not to be trusted
  bool trusted = false;
  int evaluations = 0;  // of learning, in all rounds
  int round = 0;        // whose theta it is, from 0
};

// Any may be empty. on_round is called before a round from the thread of FindDemonstrations, with how many variations
// are tried in it; the others from the threads of the variations, those of one variation in order.
struct DemonstrationObserver {
  std::function<void(int round, std::size_t variations)> on_round{};
  std::function<void(std::size_t variation)> on_evaluation{};
  std::function<void(std::size_t variation, const Demonstration&)> on_end{};
};

// In the order of the stream. A pure function of its first two arguments and the service's answers. Throws
// std::invalid_argument for a bad problem or bad options, and what the service throws.
std::vector<Demonstration> FindDemonstrations(const Problem& problem, const DemonstrationOptions& options,
                                              RolloutService& service, const DemonstrationObserver& observer);

}  // namespace knap
