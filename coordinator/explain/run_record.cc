#include "coordinator/explain/run_record.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "coordinator/run_directory/durable_file.h"
#include "sim/scenarios/csv_text.h"

namespace knap {
namespace {

using Json = nlohmann::ordered_json;

// A member of an event that another version, or a damaged line, may have otherwise.
std::string GetText(const Json& object, const char* name) {
  const auto found = object.find(name);
  return found != object.end() && found->is_string() ? found->get<std::string>() : "";
}

double GetNumber(const Json& object, const char* name) {
  const auto found = object.find(name);
  return found != object.end() && found->is_number() ? found->get<double>() : 0.0;
}

std::int64_t GetCount(const Json& object, const char* name) {
  const double number = GetNumber(object, name);
  return std::abs(number) < 9e15 ? static_cast<std::int64_t>(number) : 0;
}

int GetSmall(const Json& object, const char* name) {
  return static_cast<int>(std::clamp(GetNumber(object, name), 0.0, 1e9));
}

class EventReader {
 public:
  explicit EventReader(RunRecord* record) : record_(*record) {}

  void Read(const Json& event) {
    const std::string name = GetText(event, "event");
    const double time_s = GetNumber(event, "time_s");
    if (name == "begin") {
      record_.lives.push_back({.begin_s = time_s, .answers_from_journal = GetCount(event, "answers_from_journal")});
    } else if (name == "done" || name == "interrupted" || name == "failed") {
      if (!record_.lives.empty()) {
        record_.lives.back().end = name;
        record_.lives.back().error = GetText(event, "error");
      }
    } else if (name == "worker_gone") {
      const std::size_t held = AddSetbacks(event, GetText(event, "why"));
      record_.gone.push_back({time_s, GetText(event, "worker"), GetText(event, "host"), GetText(event, "why"), held});
    } else if (name == "requests_dropped") {
      AddSetbacks(event, "dropped");
    } else if (name == "requests_copied") {
      record_.copied += GetCount(event, "count");
      AddSetbacks(event, "straggler");
    } else if (name == "requests_resent") {
      AddSetbacks(event, "message_lost");
    } else if (name == "requests_reissued") {
      record_.reissued += GetCount(event, "count");
    } else if (name == "workers_lost") {
      record_.workers_lost += GetCount(event, "count");
    } else if (name == "worker_refused" || name == "worker_left") {
      record_.remarks.emplace_back(time_s, (name == "worker_refused" ? "refused " : "") + GetText(event, "why"));
    }
    if (!record_.lives.empty()) record_.lives.back().end_s = std::max(record_.lives.back().end_s, time_s);
  }

 private:
  // How many requests the event names.
  std::size_t AddSetbacks(const Json& event, const std::string& why) {
    const auto requests = event.find("requests");
    if (requests == event.end() || !requests->is_array()) return 0;
    for (const Json& request : *requests) {
      if (!request.is_object() || GetText(request, "id").empty()) continue;
      RequestSetback& setback = record_.setbacks.emplace_back();
      setback.life = record_.lives.empty() ? 0 : record_.lives.size() - 1;
      setback.time_s = GetNumber(request.contains("time_s") ? request : event, "time_s");
      setback.id = GetText(request, "id");
      setback.why = why;
      setback.worker = GetText(request.contains("worker") ? request : event, "worker");
      setback.attempt = GetSmall(request, "attempt");
      setback.held_s = GetNumber(request, "held_s");
      setback.copy_to = GetText(request, "copy_to");
      setback.copy_attempt = GetSmall(request, "copy_attempt");
    }
    return requests->size();
  }

  RunRecord& record_;
};

void ReadInfo(const RunDirectory& run, RunRecord* record) {
  const Json info = Json::parse(ReadFile(run.info_path()), nullptr, false);
  if (!info.is_object()) return;
  record->scenario = GetText(info, "scenario");
  record->method = GetText(info, "method");
  record->host = GetText(info, "host");
  record->started = GetText(info, "started_utc");
  record->seed = GetCount(info, "seed");
  if (const auto identity = info.find("identity"); identity != info.end() && identity->is_object()) {
    record->engine = GetText(*identity, "engine");
  }
}

}  // namespace

std::size_t RunRecord::FindLife(double time_s) const {
  std::size_t life = 0;
  while (life + 1 < lives.size() && lives[life + 1].begin_s < time_s) ++life;
  return life;
}

RunRecord ReadRunRecord(const RunDirectory& run) {
  RunRecord record;
  ReadInfo(run, &record);
  const std::string rollouts = ReadFile(run.rollouts_path());
  // The columns came with the events that tell why.
  record.tells_why = rollouts.substr(0, rollouts.find('\n')).ends_with(",waited_s,held_s");
  record.answers = ReadRollouts(run.rollouts_path());
  if (std::filesystem::exists(run.events_path())) {
    EventReader reader(&record);
    for (const Json& event : ParseEvents(ReadFile(run.events_path()))) reader.Read(event);
  }
  for (const RolloutRow& answer : record.answers) {
    if (record.lives.empty()) break;
    RecordedLife& life = record.lives[record.FindLife(answer.time_s)];
    if (answer.time_s > life.end_s) life.end_s = answer.time_s;
  }
  return record;
}

std::vector<TriedDesign> ReadTriedDesigns(const RunDirectory& run, const std::vector<std::string>& names) {
  std::vector<TriedDesign> designs;
  if (!std::filesystem::exists(run.metrics_path())) return designs;
  const CsvTable metrics(ReadFile(run.metrics_path()));
  if (!std::all_of(names.begin(), names.end(), [&](const std::string& name) { return metrics.Has(name); })) {
    return designs;
  }
  for (std::size_t i = 0; i < metrics.size(); ++i) {
    TriedDesign& design = designs.emplace_back();
    design.batch = static_cast<int>(metrics.GetNumber(i, "batch"));
    design.evaluation = static_cast<int>(metrics.GetNumber(i, "evaluation"));
    for (const std::string& name : names) design.theta.push_back(metrics.GetNumber(i, name));
  }
  return designs;
}

}  // namespace knap
