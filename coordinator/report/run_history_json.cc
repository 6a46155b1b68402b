#include "coordinator/report/run_history_json.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "coordinator/run_directory/durable_file.h"
#include "coordinator/run_directory/json_text.h"

namespace knap {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMostShown = 6000;  // rollouts of a timeline: what a page draws at once

Json MakeColumn(const CsvTable& table, const char* name) {
  Json column = Json::array();
  for (std::size_t i = 0; i < table.size(); ++i) column.push_back(MakeJsonNumber(table.GetNumber(i, name)));
  return column;
}

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

}  // namespace

std::vector<Json> ReadEvents(const RunDirectory& run) {
  std::vector<Json> events;
  std::istringstream text(ReadFile(run.events_path()));
  for (std::string line; std::getline(text, line);) {
    Json event = Json::parse(line, nullptr, false);
    if (event.is_object()) events.push_back(std::move(event));
  }
  return events;
}

Json MakeLearningJson(const RunDirectory& run) {
  const CsvTable metrics(ReadFile(run.metrics_path()));
  Json evaluations = Json::object();
  for (const char* name : {"time_s", "batch", "loss", "task_loss", "distillation_loss", "gradient_norm", "best_loss",
                           "accepted", "successes", "rollouts", "untrusted"}) {
    evaluations[name] = MakeColumn(metrics, name);
  }
  // A resumed run tells of its first batches again, in the same words.
  std::map<std::int64_t, Json> sizes, batches, validations;
  for (const Json& event : ReadEvents(run)) {
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

Json MakeTimelineJson(const RunDirectory& run, const CsvTable& rollouts) {
  std::vector<std::string> workers;
  Json worker = Json::array();
  Json kind = Json::array();
  Json end_s = Json::array();
  Json duration_s = Json::array();
  Json attempt = Json::array();
  const std::size_t every = 1 + (rollouts.size() == 0 ? 0 : (rollouts.size() - 1) / kMostShown);
  for (std::size_t i = 0; i < rollouts.size(); i += every) {
    const std::string& name = rollouts.Get(i, "worker");
    const auto found = std::find(workers.begin(), workers.end(), name);
    worker.push_back(found - workers.begin());
    if (found == workers.end()) workers.push_back(name);
    kind.push_back(rollouts.Get(i, "kind"));
    end_s.push_back(MakeJsonNumber(rollouts.GetNumber(i, "time_s")));
    duration_s.push_back(MakeJsonNumber(rollouts.GetNumber(i, "forward_s") + rollouts.GetNumber(i, "gradient_s")));
    attempt.push_back(MakeJsonNumber(rollouts.GetNumber(i, "attempt")));
  }
  // What the other charts show is left out.
  constexpr std::array<const char*, 5> kToldElsewhere = {"batch_start", "batch_box", "batch_end", "validation", "test"};
  Json events = Json::array();
  for (const Json& event : ReadEvents(run)) {
    const std::string name = event.value("event", "");
    if (std::find(kToldElsewhere.begin(), kToldElsewhere.end(), name) != kToldElsewhere.end()) continue;
    events.push_back({{"time_s", event.value("time_s", 0.0)}, {"event", name}, {"text", DescribeDetails(event)}});
  }
  return {{"workers", workers},
          {"every", every},
          {"rollouts",
           {{"worker", std::move(worker)},
            {"kind", std::move(kind)},
            {"end_s", std::move(end_s)},
            {"duration_s", std::move(duration_s)},
            {"attempt", std::move(attempt)}}},
          {"events", std::move(events)}};
}

Json MakeCertificatesJson(const CsvTable& rollouts) {
  int gradients = 0;
  int flagged = 0;
  int untrusted = 0;
  int not_converged = 0;
  double deepest = 0.0;
  double largest_force = 0.0;
  for (std::size_t i = 0; i < rollouts.size(); ++i) {
    // Tests and validations ask for no gradient.
    if (rollouts.Get(i, "kind") != "test" && rollouts.Get(i, "kind") != "validation") {
      ++gradients;
      flagged += rollouts.Get(i, "gradient_reliable") == "0" ? 1 : 0;
    }
    untrusted += rollouts.Get(i, "distrust").empty() ? 0 : 1;
    not_converged += rollouts.Get(i, "converged") == "0" ? 1 : 0;
    if (const double x = rollouts.GetNumber(i, "penetration"); x > deepest) deepest = x;
    if (const double x = rollouts.GetNumber(i, "largest_force"); x > largest_force) largest_force = x;
  }
  return {{"rollouts", rollouts.size()},   {"gradients", gradients},         {"gradients_flagged", flagged},
          {"untrusted", untrusted},        {"not_converged", not_converged}, {"deepest", deepest},
          {"largest_force", largest_force}};
}

}  // namespace knap
