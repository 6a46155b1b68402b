// report.html of runs beside each other: the methods of a study with their seeds, or two runs.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "coordinator/learning/problem.h"

namespace knap {

struct ComparedRun {
  std::string name;
  double rollouts = 0.0;          // of its learning
  std::vector<double> theta;      // that it learned; one value a parameter
  nlohmann::ordered_json test;    // of that (MakeEvaluationJson)
  std::filesystem::path metrics;  // its metrics.csv
};

struct ComparedGroup {
  std::string name;
  std::vector<ComparedRun> runs;  // at least one
};

struct Comparison {
  nlohmann::ordered_json run;    // name, scenario, description and more of page/README.md's `run`
  nlohmann::ordered_json build;  // its `knap`
  const Problem* problem = nullptr;
  std::string loss_unit;  // see ReportSource
  bool has_success = true;
  bool of_runs = false;            // each group is one run
  nlohmann::ordered_json initial;  // the initial design's test; null where the runs have different ones
  std::vector<ComparedGroup> groups;
  std::vector<std::string> repeat;  // commands
};

// Throws std::system_error or std::runtime_error where a run's metrics cannot be read.
std::string MakeComparisonPage(const Comparison& comparison);

}  // namespace knap
