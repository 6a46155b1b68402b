#include "coordinator/report/report_document.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <map>
#include <utility>
#include <vector>

#include "coordinator/report/document_parts.h"
#include "coordinator/report/replay_json.h"
#include "coordinator/report/report_page.h"
#include "coordinator/report/run_history.h"
#include "coordinator/run_directory/durable_file.h"

namespace knap {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::int64_t kMostReplayed = 24;     // variations
constexpr std::size_t kMostBytes = 3'500'000;  // of all replays: a page stays below 5 MB

Json ReadJson(const std::filesystem::path& path) { return Json::parse(ReadFile(path)); }

// The reasons without their figures: "a and b press into one another".
std::map<std::string, int> CountDistrust(const ReportedTest& test) {
  std::map<std::string, int> counts;
  for (const std::optional<RolloutOutcome>& outcome : test.outcomes) {
    if (!outcome || outcome->certificate.distrust.empty()) continue;
    const std::string& reason = outcome->certificate.distrust;
    ++counts[reason.substr(0, reason.find(','))];
  }
  return counts;
}

Json MakeTestJson(const ReportSource& source, const Json& evaluation) {
  Json json = {{"variations", source.variations.size()}, {"seed", evaluation["initial"].value("seed", 0)}};
  for (const ReportedTest& test : source.tests) {
    json[test.name] = evaluation[test.name];
    json[test.name]["distrust"] = CountDistrust(test);
  }
  return json;
}

// "replays", and what belongs to them: "bodies", "gravity", "fixed_poses".
void AddReplays(const ReportSource& source, const std::function<void(int, int)>& progress, Json* page) {
  const std::vector<std::size_t> order = ChooseReplays(source, source.model->scene().success.has_value());
  const int total = CountReplays(static_cast<std::int64_t>(order.size()));
  Json replays = Json::array();
  std::size_t bytes = 0;
  for (std::size_t k = 0; static_cast<int>(replays.size()) < total && bytes < kMostBytes; ++k) {
    for (const ReportedTest& test : source.tests) {
      Json replay = RecordReplayJson(source, test, order[k], page);
      bytes += replay.dump().size();
      replays.push_back(std::move(replay));
    }
    if (progress) progress(static_cast<int>(replays.size()), total);
  }
  (*page)["replays"] = std::move(replays);
}

Json MakeRepeatJson(const ReportSource& source) {
  const std::string run = source.run->path().string();
  return {fmt::format("knap learn {}", (source.run->path() / "config.yaml").string()),
          fmt::format("knap evaluate {} --variations 1000 --csv test.csv", run),
          fmt::format("knap rollout {} --theta learned --variation 0 --trajectory motion.csv", run),
          fmt::format("knap report {}", run)};
}

}  // namespace

int CountReplays(std::int64_t variations) {
  // Of two tools each.
  return 2 * static_cast<int>(std::clamp<std::int64_t>(variations, 0, kMostReplayed));
}

std::string MakeReportPage(const ReportSource& source, const std::function<void(int, int)>& progress) {
  Json data = MakeHeadJson(source, ReadJson(source.run->result_path()));
  data["theta"] = MakeThetaJson(source);
  data["test"] = MakeTestJson(source, ReadJson(source.run->evaluation_path()));
  data["variation"] = MakeVariationJson(source);
  AddReplays(source, progress, &data);
  RunHistory history(*source.run);
  history.Read();
  data["learning"] = history.MakeLearningJson();
  data["timeline"] = history.MakeTimelineJson();
  data["certificates"] = history.MakeCertificatesJson();
  data["repeat"] = MakeRepeatJson(source);
  return MakePage(data);
}

}  // namespace knap
