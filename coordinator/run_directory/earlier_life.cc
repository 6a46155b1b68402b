#include "coordinator/run_directory/earlier_life.h"

#include <algorithm>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "coordinator/run_directory/durable_file.h"
#include "sim/scenarios/csv_text.h"

namespace knap {
namespace {

std::vector<std::string> ReadWholeLines(const std::filesystem::path& path) {
  std::vector<std::string> lines;
  if (!std::filesystem::exists(path)) return lines;
  std::string text = ReadFile(path);
  text.resize(text.rfind('\n') + 1);  // npos + 1 = 0: no whole line
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

}  // namespace

EarlierLife ReadEarlierLife(const RunDirectory& run) {
  EarlierLife life;
  for (const std::string& line : ReadWholeLines(run.events_path())) {
    const nlohmann::json event = nlohmann::json::parse(line, nullptr, false);
    if (!event.is_object()) continue;
    life.worked_s = std::max(life.worked_s, event.value("time_s", 0.0));
    if (event.value("event", "") == "requests_reissued") life.reissued = event.value("total", life.reissued);
  }
  if (!std::filesystem::exists(run.rollouts_path())) return life;
  const CsvTable rollouts(ReadFile(run.rollouts_path()));
  for (std::size_t i = 0; i < rollouts.size(); ++i) {
    const double time_s = rollouts.GetNumber(i, "time_s");
    if (time_s > life.worked_s) life.worked_s = time_s;
  }
  return life;
}

}  // namespace knap
