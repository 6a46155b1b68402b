// The times that a request was given to a worker, put together from answers and setbacks.
#pragma once

#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "coordinator/explain/run_record.h"

namespace knap {

struct RequestAttempt {
  std::size_t life = 0;
  int number = 0;      // from 1 in each life
  std::string worker;  // empty: not recorded, or, of one that was dropped, none: it waited for one
  double given_s = std::numeric_limits<double>::quiet_NaN();  // NaN: not recorded
  const RolloutRow* answer = nullptr;                         // null: none came of it, or another was first
  const RequestSetback* lost = nullptr;                       // why it ended without one, or was believed to
  const RequestSetback* copy_of = nullptr;                    // it is the second copy of a straggler
  const RequestSetback* copied = nullptr;                     // an idle worker got a second copy meanwhile
  std::vector<const RequestSetback*> resent{};                // its messages were lost, and sent again
};

// In order of life and number. What is not on record, an attempt between recorded ones, was in a run that tells why a
// move: taken from the queue of a worker before that began with it, for one that had nothing to do. Points into
// `record`.
std::vector<RequestAttempt> ListAttempts(const RunRecord& record, const std::string& id);

// Whether the attempt was such a move, or in a run that does not tell why may have been.
bool IsUnrecorded(const RequestAttempt& attempt);

}  // namespace knap
