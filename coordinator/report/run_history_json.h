// How a run went, from the files that it wrote while it went: metrics.csv, rollouts.csv, events.jsonl.
#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "coordinator/run_directory/run_directory.h"
#include "sim/scenarios/csv_text.h"

namespace knap {

// The objects of events.jsonl, in order.
std::vector<nlohmann::ordered_json> ReadEvents(const RunDirectory& run);
// One entry an optimizer evaluation and one a batch.
nlohmann::ordered_json MakeLearningJson(const RunDirectory& run);
// Who computed what and when. Of a long run every k-th rollout, `every` says which k.
nlohmann::ordered_json MakeTimelineJson(const RunDirectory& run, const CsvTable& rollouts);
// What the rollouts' certificates add up to.
nlohmann::ordered_json MakeCertificatesJson(const CsvTable& rollouts);

}  // namespace knap
