#include "coordinator/report/trace_json.h"

#include <cstdint>
#include <map>
#include <string>
#include <utility>

#include "coordinator/report/run_history.h"
#include "coordinator/run_directory/durable_file.h"
#include "coordinator/run_directory/json_text.h"
#include "sim/scenarios/csv_text.h"

namespace knap {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kProcess = 1;
constexpr int kCoordinator = 0;  // its row; workers follow

Json MakeName(int row, const std::string& name) {
  return {{"ph", "M"}, {"name", "thread_name"}, {"pid", kProcess}, {"tid", row}, {"args", {{"name", name}}}};
}

Json MakeSlice(int row, const std::string& name, double begin_s, double end_s, Json details) {
  return {{"ph", "X"},
          {"name", name},
          {"pid", kProcess},
          {"tid", row},
          {"ts", 1e6 * begin_s},
          {"dur", 1e6 * (end_s - begin_s)},
          {"args", std::move(details)}};
}

// What an event tells beside its time and name.
Json TakeDetails(Json event) {
  event.erase("time_s");
  event.erase("event");
  return event;
}

void AddCoordinator(const RunDirectory& run, Json* events) {
  RunHistory history(run);
  history.Read();
  events->push_back(MakeName(kCoordinator, "coordinator"));
  std::map<std::int64_t, double> began;  // by batch
  for (const Json& event : history.events()) {
    const std::string name = event.value("event", "");
    const double time_s = event.value("time_s", 0.0);
    const std::int64_t batch = event.value("batch", std::int64_t{0});
    if (name == "batch_start") {
      began[batch] = time_s;
    } else if (name == "batch_end" && began.contains(batch)) {
      events->push_back(
          MakeSlice(kCoordinator, "batch " + std::to_string(batch), began[batch], time_s, TakeDetails(event)));
    } else {
      events->push_back({{"ph", "i"},
                         {"s", "p"},
                         {"name", name},
                         {"pid", kProcess},
                         {"tid", kCoordinator},
                         {"ts", 1e6 * time_s},
                         {"args", TakeDetails(event)}});
    }
  }
}

void AddWorkers(const RunDirectory& run, Json* events) {
  const CsvTable rollouts(ReadFile(run.rollouts_path()));
  std::map<std::string, int> rows;
  for (std::size_t i = 0; i < rollouts.size(); ++i) {
    const std::string& worker = rollouts.Get(i, "worker");
    const auto [row, is_new] = rows.try_emplace(worker, kCoordinator + 1 + static_cast<int>(rows.size()));
    if (is_new) events->push_back(MakeName(row->second, worker));
    const double end_s = rollouts.GetNumber(i, "time_s");
    const double begin_s = end_s - rollouts.GetNumber(i, "forward_s") - rollouts.GetNumber(i, "gradient_s");
    events->push_back(MakeSlice(row->second, rollouts.Get(i, "kind"), begin_s, end_s,
                                {{"id", rollouts.Get(i, "id")},
                                 {"variation", rollouts.Get(i, "variation")},
                                 {"attempt", MakeJsonNumber(rollouts.GetNumber(i, "attempt"))},
                                 {"loss", MakeJsonNumber(rollouts.GetNumber(i, "loss"))},
                                 {"success", rollouts.Get(i, "success") == "1"},
                                 {"distrust", rollouts.Get(i, "distrust")}}));
  }
}

}  // namespace

Json MakeTraceJson(const RunDirectory& run) {
  Json events = Json::array();
  AddCoordinator(run, &events);
  AddWorkers(run, &events);
  return {{"traceEvents", std::move(events)}, {"displayTimeUnit", "ms"}};
}

}  // namespace knap
