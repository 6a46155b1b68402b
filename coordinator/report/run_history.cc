#include "coordinator/report/run_history.h"

#include <algorithm>
#include <cstddef>
#include <initializer_list>
#include <map>
#include <utility>

#include "coordinator/run_directory/json_text.h"
#include "coordinator/run_directory/run_logs.h"
#include "sim/scenarios/csv_text.h"

namespace knap {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMostShown = 6000;  // rollouts of a timeline: what a page draws at once

Json Pick(const Json& event, std::initializer_list<const char*> names) {
  Json picked = Json::object();
  for (const char* name : names) picked[name] = event.contains(name) ? event[name] : Json();
  return picked;
}

Json ListValues(const std::map<std::int64_t, Json>& by_number) {
  Json list = Json::array();
  for (const auto& [number, value] : by_number) list.push_back(value);
  return list;
}

// What an event's other members tell, in words.
std::string DescribeDetails(const Json& event) {
  std::string text;
  for (const auto& [key, value] : event.items()) {
    if (key == "time_s" || key == "event" || value.is_array() || value.is_object()) continue;
    text += (text.empty() ? "" : ", ") + key + " " + (value.is_string() ? value.get<std::string>() : value.dump());
  }
  return text;
}

// Lines of a table whose header is among the first ones that are ever taken, which is kept.
CsvTable MakeTable(const std::string& lines, std::string* header) {
  if (!header->empty()) return CsvTable(*header + lines);
  *header = lines.substr(0, lines.find('\n') + 1);
  return CsvTable(lines);
}

// Of a name in a list that it is added to where it is new.
int FindPlace(const std::string& name, std::vector<std::string>* names) {
  const auto found = std::find(names->begin(), names->end(), name);
  const auto place = static_cast<int>(found - names->begin());
  if (found == names->end()) names->push_back(name);
  return place;
}

}  // namespace

RunHistory::RunHistory(const RunDirectory& run)
    : event_lines_(run.events_path()), metric_lines_(run.metrics_path()), rollout_lines_(run.rollouts_path()) {}

void RunHistory::Read() {
  ReadEvents();
  ReadMetrics();
  ReadRollouts();
}

void RunHistory::ReadEvents() {
  for (Json& event : ParseEvents(event_lines_.Take().lines)) {
    // A run that goes on begins metrics.csv anew, however soon that is as long as what was read of it.
    if (event.value("event", "") == "begin" && ++lives_ > 1) {
      metric_lines_.Rewind();
      RestartMetrics();
    }
    events_.push_back(std::move(event));
  }
}

void RunHistory::ReadMetrics() {
  const GrowingFile::Piece piece = metric_lines_.Take();
  if (piece.begins_anew) RestartMetrics();
  const CsvTable table = MakeTable(piece.lines, &metrics_header_);
  for (std::size_t k = 0; k < kMetrics.size(); ++k) {
    for (std::size_t i = 0; i < table.size(); ++i) metrics_[k].push_back(table.GetNumber(i, kMetrics[k]));
  }
}

void RunHistory::RestartMetrics() {
  metrics_header_.clear();
  for (std::vector<double>& column : metrics_) column.clear();
}

void RunHistory::ReadRollouts() {
  const CsvTable table = MakeTable(rollout_lines_.Take().lines, &rollouts_header_);
  for (std::size_t i = 0; i < table.size(); ++i) {
    const std::string& kind = table.Get(i, "kind");
    const double duration_s = table.GetNumber(i, "forward_s") + table.GetNumber(i, "gradient_s");
    rollouts_.push_back({FindPlace(table.Get(i, "worker"), &workers_), FindPlace(kind, &kinds_),
                         table.GetNumber(i, "attempt"), table.GetNumber(i, "time_s"), duration_s});
    // Tests and validations ask for no gradient.
    if (kind != "test" && kind != "validation") {
      ++gradients_;
      flagged_ += table.Get(i, "gradient_reliable") == "0" ? 1 : 0;
    }
    const bool gave_up = table.Get(i, "converged") == "0";
    not_converged_ += gave_up ? 1 : 0;
    untrusted_ += gave_up || table.Get(i, "distrust").empty() ? 0 : 1;
    if (const double x = table.GetNumber(i, "penetration"); x > deepest_) deepest_ = x;
    if (const double x = table.GetNumber(i, "largest_force"); x > largest_force_) largest_force_ = x;
  }
}

Json RunHistory::MakeLearningJson() const {
  Json evaluations = Json::object();
  for (std::size_t k = 0; k < kMetrics.size(); ++k) {
    Json column = Json::array();
    for (const double value : metrics_[k]) column.push_back(MakeJsonNumber(value));
    evaluations[kMetrics[k]] = std::move(column);
  }
  // A resumed run tells of its first batches again, in the same words.
  std::map<std::int64_t, Json> sizes, batches, validations;
  for (const Json& event : events_) {
    const std::string name = event.value("event", "");
    const std::int64_t number = event.value("batch", std::int64_t{0});
    if (name == "batch_start") sizes[number] = event.value("variations", Json::array()).size();
    if (name == "batch_end")
      batches[number] = Pick(event, {"batch", "theta", "start_loss", "best_loss", "evaluations", "stop"});
    if (name == "validation") validations[number] = Pick(event, {"batch", "loss_mean", "success_rate", "best"});
  }
  for (auto& [number, batch] : batches) batch["variations"] = sizes.contains(number) ? sizes[number] : Json();
  return {{"evaluations", std::move(evaluations)},
          {"batches", ListValues(batches)},
          {"validations", ListValues(validations)}};
}

Json RunHistory::MakeTimelineJson() const {
  Json worker = Json::array();
  Json kind = Json::array();
  Json end_s = Json::array();
  Json duration_s = Json::array();
  Json attempt = Json::array();
  const std::size_t every = 1 + (rollouts_.empty() ? 0 : (rollouts_.size() - 1) / kMostShown);
  for (std::size_t i = 0; i < rollouts_.size(); i += every) {
    const Rollout& rollout = rollouts_[i];
    worker.push_back(rollout.worker);
    kind.push_back(kinds_[static_cast<std::size_t>(rollout.kind)]);
    end_s.push_back(MakeJsonNumber(rollout.end_s));
    duration_s.push_back(MakeJsonNumber(rollout.duration_s));
    attempt.push_back(MakeJsonNumber(rollout.attempt));
  }
  // What the other charts show is left out.
  constexpr std::array<const char*, 5> kToldElsewhere = {"batch_start", "batch_box", "batch_end", "validation", "test"};
  Json events = Json::array();
  for (const Json& event : events_) {
    const std::string name = event.value("event", "");
    if (std::find(kToldElsewhere.begin(), kToldElsewhere.end(), name) != kToldElsewhere.end()) continue;
    events.push_back({{"time_s", event.value("time_s", 0.0)}, {"event", name}, {"text", DescribeDetails(event)}});
  }
  return {{"workers", workers_},
          {"every", every},
          {"rollouts",
           {{"worker", std::move(worker)},
            {"kind", std::move(kind)},
            {"end_s", std::move(end_s)},
            {"duration_s", std::move(duration_s)},
            {"attempt", std::move(attempt)}}},
          {"events", std::move(events)}};
}

Json RunHistory::MakeCertificatesJson() const {
  return {{"rollouts", rollouts_.size()},   {"gradients", gradients_},         {"gradients_flagged", flagged_},
          {"untrusted", untrusted_},        {"not_converged", not_converged_}, {"deepest", deepest_},
          {"largest_force", largest_force_}};
}

}  // namespace knap
