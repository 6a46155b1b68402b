#include "coordinator/report/live_document.h"

#include <fmt/format.h>

#include <cstddef>
#include <utility>

#include "coordinator/report/document_parts.h"
#include "coordinator/report/report_page.h"
#include "coordinator/run_directory/json_text.h"

namespace knap {
namespace {

using Json = nlohmann::ordered_json;

Json MakeReplays(const ReportSource& source, std::size_t test, Json* page) {
  Json replays = Json::array();
  for (std::size_t i = 0; i < source.variations.size(); ++i) {
    replays.push_back(RecordReplayJson(source, source.tests[test], i, page));
  }
  return replays;
}

void Append(const Json& more, Json* list) {
  for (const Json& one : more) list->push_back(one);
}

}  // namespace

LiveDocument::LiveDocument(ReportSource source,
                           std::function<ReportedTest(const std::string&, const std::vector<double>&)> make_test)
    : source_(std::move(source)), make_test_(std::move(make_test)), history_(*source_.run) {
  const std::vector<double>& initial = source_.problem->parameters.initial;
  source_.tests = {make_test_("initial", initial), make_test_("learned", initial)};
}

void LiveDocument::Update() {
  history_.Read();
  for (; events_seen_ < history_.events().size(); ++events_seen_) {
    const Json& event = history_.events()[events_seen_];
    const std::string name = event.value("event", "");
    if (name == "begin") run_id_ = event.value("run_id", "");
    if (name == "batch_end" && event.contains("theta")) {
      source_.tests[1] = make_test_("learned", event["theta"].get<std::vector<double>>());
      ++version_;
    }
  }
  if (replayed_ == version_) return;
  if (initial_replays_.is_null()) initial_replays_ = MakeReplays(source_, 0, &bodies_);
  learned_replays_ = MakeReplays(source_, 1, &bodies_);
  replayed_ = version_;
}

Json LiveDocument::MakeLiveJson(const Json& status) const {
  Json live = {{"version", version_}, {"run", nullptr}, {"workers", Json::array()}};
  for (const Json& run : status["runs"]) {
    if (run["run_id"] == run_id_) live["run"] = run;
  }
  for (const Json& worker : status["workers"]) {
    if (worker["run_id"] == run_id_) live["workers"].push_back(worker);
  }
  return live;
}

void LiveDocument::AddHistory(Json* data) const {
  (*data)["learning"] = history_.MakeLearningJson();
  (*data)["timeline"] = history_.MakeTimelineJson();
  (*data)["certificates"] = history_.MakeCertificatesJson();
}

std::string LiveDocument::MakePage(const Json& status) {
  Update();
  Json data = MakeHeadJson(source_, Json::object());
  data["live"] = MakeLiveJson(status);
  data["theta"] = MakeThetaJson(source_);
  data["variation"] = MakeVariationJson(source_);
  data.update(bodies_);
  data["replays"] = Json::array();
  Append(initial_replays_, &data["replays"]);
  Append(learned_replays_, &data["replays"]);
  AddHistory(&data);
  const std::string run = source_.run->path().string();
  data["repeat"] = {fmt::format("knap status {}", run), fmt::format("knap learn --resume {}", run)};
  return MakeLivePage(data);
}

std::string LiveDocument::MakeNews(const Json& status, const std::string& seen) {
  Update();
  Json data = {{"live", MakeLiveJson(status)}};
  if (seen != std::to_string(version_)) {
    data["theta"] = {{"learned", MakeThetaJson(source_)["learned"]}};
    data["replays"] = learned_replays_;
  }
  AddHistory(&data);
  return MakeJsonText(data, -1);
}

}  // namespace knap
