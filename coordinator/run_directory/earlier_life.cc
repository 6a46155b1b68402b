#include "coordinator/run_directory/earlier_life.h"

#include <algorithm>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "coordinator/run_directory/durable_file.h"

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

std::vector<std::string> Split(const std::string& line) {
  std::vector<std::string> fields;
  std::istringstream stream(line);
  for (std::string field; std::getline(stream, field, ',');) fields.push_back(field);
  return fields;
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
  const std::vector<std::string> rows = ReadWholeLines(run.rollouts_path());
  if (rows.empty()) return life;
  const std::vector<std::string> names = Split(rows.front());
  const auto column = static_cast<std::size_t>(std::find(names.begin(), names.end(), "time_s") - names.begin());
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const std::vector<std::string> fields = Split(rows[i]);
    if (column < fields.size()) life.worked_s = std::max(life.worked_s, std::strtod(fields[column].c_str(), nullptr));
  }
  return life;
}

}  // namespace knap
