// What the programs that worked on a run before this one left in its logs, so that a resumed run's figures count them.
#pragma once

#include <cstdint>

#include "coordinator/run_directory/run_directory.h"

namespace knap {

struct EarlierLife {
  double worked_s = 0.0;      // up to the last line that was written; the pauses in between do not count
  std::int64_t reissued = 0;  // requests given to another worker
};

// From events.jsonl and rollouts.csv, whose times go on where the program before stopped; zeros for a new run. Half
// lines that a crash left are passed over. Throws std::system_error when a file cannot be read.
EarlierLife ReadEarlierLife(const RunDirectory& run);

}  // namespace knap
