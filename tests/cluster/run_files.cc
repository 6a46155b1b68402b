#include "tests/cluster/run_files.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/cluster/child_process.h"

namespace knap {

std::map<std::string, std::vector<std::string>> ReadCsv(const std::filesystem::path& path) {
  std::istringstream lines(ReadText(path));
  std::vector<std::string> names;
  std::map<std::string, std::vector<std::string>> columns;
  for (std::string line; std::getline(lines, line);) {
    std::istringstream fields(line);
    std::size_t i = 0;
    for (std::string field; std::getline(fields, field, ','); ++i) {
      if (columns.size() <= i && names.size() <= i) {
        names.push_back(field);
        columns[field];
      } else {
        columns[names.at(i)].push_back(field);
      }
    }
  }
  return columns;
}

void ExpectSameRun(const std::filesystem::path& run, const std::filesystem::path& reference) {
  const auto read = [](const std::filesystem::path& folder) {
    return nlohmann::json::parse(ReadText(folder / "result.json"));
  };
  const nlohmann::json a = read(run), b = read(reference);
  EXPECT_EQ(a["theta"], b["theta"]) << run;
  EXPECT_EQ(a["test"], b["test"]) << run;
  EXPECT_EQ(a["rollouts"]["distinct"], b["rollouts"]["distinct"]) << run;
  auto metrics = ReadCsv(run / "metrics.csv"), reference_metrics = ReadCsv(reference / "metrics.csv");
  metrics.erase("time_s");
  reference_metrics.erase("time_s");
  EXPECT_EQ(metrics, reference_metrics) << run;
  EXPECT_EQ(ReadText(run / "tool/learned.stl"), ReadText(reference / "tool/learned.stl")) << run;
}

}  // namespace knap
