// A request of a run found again by its id, to be computed alone and looked at: one that was poison, or on which two
// workers disagreed.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "coordinator/learning/learning_options.h"
#include "coordinator/learning/problem.h"
#include "coordinator/rollout_service.h"
#include "lcmtypes/wire/content_id.h"

namespace knap {

struct ReplayedRun {
  Problem problem;
  LearningOptions options;
  int tests = 0;  // variations of the test
  std::uint64_t test_seed = 0;
  ContentId scenario{};
};

// Learns and tests again with the answers of `payloads` (the run's journal, see answer_journal.h), as --resume does, up
// to a request whose id begins with these hexadecimal digits. Empty when the run asks for none before answers are
// missing.
std::optional<RolloutQuery> FindRequest(const ReplayedRun& run, std::span<const std::string> payloads,
                                        const std::string& id);

}  // namespace knap
