#include "sim/rollout/recorded_paths.h"

#include <fmt/format.h>

#include <stdexcept>
#include <variant>
#include <vector>

#include "sim/scenarios/number_table.h"

namespace knap {

namespace {

// The file and the columns that a body's motion follows; none where it follows no file.
std::pair<std::string, std::vector<std::string>> FindColumns(const Body& body) {
  const auto* joint = std::get_if<PrescribedJoint>(&body.joint.kind);
  if (joint == nullptr) return {};
  if (const auto* path = std::get_if<PathMotion>(&joint->motion)) {
    return {path->file, {std::begin(kPathColumns), std::end(kPathColumns)}};
  }
  if (const auto* path = std::get_if<JointPathMotion>(&joint->motion)) return {path->file, {path->column}};
  return {};
}

}  // namespace

RecordedPaths ReadRecordedPaths(const World& world, const std::map<std::string, std::string>& files) {
  RecordedPaths out;
  for (const Body& body : world.bodies) {
    const auto& [file, columns] = FindColumns(body);
    if (columns.empty()) continue;
    std::vector<std::string> wanted{"time"};
    wanted.insert(wanted.end(), columns.begin(), columns.end());
    try {
      const std::vector<std::vector<double>> rows = ReadNumberTable(file, files.at(file), wanted);
      std::vector<std::vector<double>> by_column(wanted.size());
      for (std::size_t i = 0; i < rows.size(); ++i) {
        if (i > 0 && !(rows[i][0] > rows[i - 1][0])) {
          throw std::invalid_argument(
              fmt::format("{}:{}: column 'time': value '{}': must be more than that before", file, i + 2, rows[i][0]));
        }
        for (std::size_t c = 0; c < wanted.size(); ++c) by_column[c].push_back(rows[i][c]);
      }
      if (rows.size() < 2) throw std::invalid_argument(fmt::format("{}: has one row; expected at least two", file));
      for (std::size_t c = 1; c < wanted.size(); ++c) {
        out.try_emplace({file, wanted[c]}, by_column[0], by_column[c]);
      }
    } catch (const std::invalid_argument& error) {
      throw std::runtime_error(fmt::format("path of '{}': {}", body.name, error.what()));
    }
  }
  return out;
}

}  // namespace knap
