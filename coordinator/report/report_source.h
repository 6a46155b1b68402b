// What the report of a run is made from [docs/architecture.md].
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "coordinator/learning/problem.h"
#include "coordinator/rollout_service.h"
#include "coordinator/run_directory/run_directory.h"
#include "sim/rollout/rollout.h"

namespace knap {

// One design on the run's test variations.
struct ReportedTest {
  std::string name;                                     // "initial" or "learned"
  std::vector<double> theta;                            // d values
  std::vector<std::string> ids;                         // of the requests, one a variation
  std::vector<std::optional<RolloutOutcome>> outcomes;  // likewise; empty where the run has no answer
};

struct ReportSource {
  const RunDirectory* run = nullptr;
  const Problem* problem = nullptr;
  RolloutModel* model = nullptr;
  std::string loss_unit;                        // "mm²", or a note in brackets about several; empty: none
  std::vector<std::vector<double>> variations;  // of the test
  std::vector<ReportedTest> tests;              // initial, learned
};

}  // namespace knap
