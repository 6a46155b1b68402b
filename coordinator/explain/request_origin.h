// Where in its run a request was asked: with which design, on which variation. Found by content ids alone, which are
// hashes of just that: nothing is computed.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "coordinator/explain/run_record.h"
#include "coordinator/learning/learning_options.h"
#include "coordinator/learning/problem.h"
#include "lcmtypes/wire/content_id.h"
#include "sim/scenarios/units.h"

namespace knap {

// What a run's scenario and its other files add to its record.
struct RunNames {
  std::string engine;
  ContentId scenario{};
  Problem problem;
  LearningOptions learning;
  int tests = 0;
  std::uint64_t test_seed = 0;
  std::vector<std::pair<std::string, Dimension>> varied;  // keys of a variation
  std::string loss_unit;                                  // what follows a loss, such as " mm²"
  bool has_success = false;
  std::vector<TriedDesign> tried;
  std::vector<double> learned;  // empty: the run has not ended
};

struct RequestOrigin {
  std::string design;             // "initial" or "learned"; else empty
  int batch = 0, evaluation = 0;  // otherwise the first in which this design was tried, as in metrics.csv
  std::vector<double> theta;      // all d values
  std::vector<double> reference;  // of a distillation, likewise
  int reference_batch = 0;        // which began with it
  bool gradient = false;          // asked for
};

// Empty when no design that the run has recorded makes this request.
std::optional<RequestOrigin> FindOrigin(const RolloutRow& answer, const RunNames& names);

// "test variation 7 of 0 to 199" and the like, or empty when it is none of those that the kind of the answer draws
// from.
std::string DescribeVariationNumber(const RolloutRow& answer, const RunNames& names);

// The number of a test variation with these values.
std::optional<int> FindTestVariation(const std::vector<double>& variation, const RunNames& names);

}  // namespace knap
