// Where a run is or was to be heard: each start and each resumption is a life, told by a `begin` event in events.jsonl.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "coordinator/run_directory/run_directory.h"

namespace knap {

struct RunLife {
  std::int64_t run_id = 0;
  std::string lcm_url;
  std::string key_file;  // empty: the public key
};

// In order, at least one; UsageError when the run has not begun, or was recorded by a version that did not tell.
std::vector<RunLife> ReadLives(const RunDirectory& run);

}  // namespace knap
