// Who computed what when in a run, as trace events that Perfetto and other timeline viewers open (ui.perfetto.dev).
//
// The format is that of Chrome's traces: {"traceEvents": […], "displayTimeUnit": "ms"}, times in microseconds of work
// on the run. A row for the coordinator's batches, with its other events as marks on it, and one for each worker, with
// a slice a rollout that ends when the answer came and is as long as the worker's own clock said.
#pragma once

#include <nlohmann/json.hpp>

#include "coordinator/run_directory/run_directory.h"

namespace knap {

// From rollouts.csv and events.jsonl; half lines that a crash left are passed over. Throws std::system_error when a
// file cannot be read.
nlohmann::ordered_json MakeTraceJson(const RunDirectory& run);

}  // namespace knap
