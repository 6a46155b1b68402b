// result.json, the outcome of a run, and the fuller evaluation.json beside it [README.md].
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "coordinator/learning/evaluation.h"
#include "coordinator/learning/problem.h"
#include "coordinator/learning/schedule.h"

namespace knap {

struct ResultDocument {
  std::string scenario, method;
  std::uint64_t seed = 0;
  ParameterSpec parameters;
  std::vector<double> learned;               // theta, d values
  bool has_success = true;                   // the scenario has a success test
  int batch = 0;                             // whose design was learned; 0: the initial one
  std::vector<BatchValidation> validations;  // of the initial design and of each batch's, or none
  TestSummary test_initial, test_learned;    // on the same variations: equal `variations` and `seed`
  std::int64_t rollouts_total = 0;           // asked for
  std::int64_t rollouts_distinct = 0;        // different request ids among them
  // Leases given again after the first; unset when the pool was shared, and nobody counted for this run alone.
  std::optional<std::int64_t> rollouts_reissued;
  double wall_s = 0.0;  // that programs worked on the run, the resumed ones together
};

// Schema 1, members in a fixed order. Throws std::invalid_argument when the document contradicts itself.
nlohmann::ordered_json MakeResultJson(const ResultDocument& document);

// evaluation.json: both tests in full, whether the learned design is clearly better (evaluation.h), which batch's it
// is, and all validations.
nlohmann::ordered_json MakeEvaluationsJson(const ResultDocument& document);

// One TestSummary in full: the schema's three figures, worst decile, 95% intervals, counts of untrusted rollouts.
// Without a success test its rate and interval are null, and without a finite loss all figures of the loss.
nlohmann::ordered_json MakeEvaluationJson(const TestSummary& summary, bool has_success);

}  // namespace knap
