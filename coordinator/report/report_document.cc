#include "coordinator/report/report_document.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "coordinator/report/replay_json.h"
#include "coordinator/report/report_page.h"
#include "coordinator/report/run_history_json.h"
#include "coordinator/report/scene_json.h"
#include "coordinator/report/theta_json.h"
#include "coordinator/run_directory/durable_file.h"
#include "coordinator/run_directory/json_text.h"
#include "sim/scenarios/numeric_keys.h"
#include "sim/scenarios/units.h"

namespace knap {
namespace {

using Eigen::VectorXd;
using Json = nlohmann::ordered_json;

constexpr double kFrames = 120.0;              // of a replay
constexpr std::int64_t kMostReplayed = 24;     // variations
constexpr std::size_t kMostBytes = 3'500'000;  // of all replays: a page stays below 5 MB

Json ReadJson(const std::filesystem::path& path) { return Json::parse(ReadFile(path)); }

Json MakeRunJson(const ReportSource& source, const Json& info, const Json& result) {
  const Scene& scene = source.model->scene();
  return {{"name", source.run->path().filename().string()},
          {"scenario", scene.name},
          {"description", scene.description},
          {"method", info.value("method", "")},
          {"seed", info.value("seed", 0)},
          {"host", info.value("host", "")},
          {"started", info.value("started_utc", "")},
          {"wall_s", result.value("wall_s", Json())},
          {"rollouts", result.value("rollouts", Json::object())},
          {"config_hash", info.value("config_hash", "")}};
}

Json MakeThetaJson(const ReportSource& source) {
  const ParameterSpec& parameters = source.problem->parameters;
  Json theta = MakeBoundsJson(parameters);
  theta["initial"] = TakeDesign(parameters, source.tests[0].theta);
  theta["learned"] = TakeDesign(parameters, source.tests[1].theta);
  return theta;
}

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

Json MakeOutcomesJson(const ReportedTest& test, bool has_success) {
  Json loss = Json::array();
  Json success = Json::array();
  Json distrust = Json::array();
  for (const std::optional<RolloutOutcome>& outcome : test.outcomes) {
    loss.push_back(outcome ? MakeJsonNumber(outcome->loss) : Json());
    success.push_back(outcome && has_success ? Json(outcome->success ? 1 : 0) : Json());
    distrust.push_back(outcome ? outcome->certificate.distrust : "");
  }
  return {{"loss", std::move(loss)}, {"success", std::move(success)}, {"distrust", std::move(distrust)}};
}

Json MakeVariationJson(const ReportSource& source, bool has_success) {
  Scene scene = Scene(source.model->scene());
  std::map<std::string, std::string> units;
  for (const NumericKey& key : ListNumericKeys(scene)) units[key.path] = UnitName(key.dimension);
  Json keys = Json::array();
  const std::vector<std::string> names = ListNames(source.problem->variations);
  const std::vector<DrawRange> ranges = ListDrawRanges(source.problem->variations);
  for (std::size_t i = 0; i < names.size(); ++i) {
    keys.push_back(
        {{"key", names[i]}, {"unit", units[names[i]]}, {"lower", ranges[i].lower}, {"upper", ranges[i].upper}});
  }
  return {{"keys", std::move(keys)},
          {"values", source.variations},
          {"initial", MakeOutcomesJson(source.tests[0], has_success)},
          {"learned", MakeOutcomesJson(source.tests[1], has_success)}};
}

RolloutInput MakeInput(const ReportSource& source, const ReportedTest& test, std::size_t variation) {
  const std::vector<double>& theta = test.theta;
  const auto controls = static_cast<Eigen::Index>(source.problem->parameters.controls);
  const Eigen::Map<const VectorXd> all(theta.data(), static_cast<Eigen::Index>(theta.size()));
  RolloutInput input;
  input.theta = all.head(all.size() - controls);
  input.controls = all.tail(controls);
  input.variation = source.variations[variation];
  input.want_gradient = false;
  return input;
}

// Whether the rollout that was simulated again is the one that the run had, to the last bit; null where it had none.
Json IsSame(const std::optional<RolloutOutcome>& outcome, const RolloutOutput& again) {
  if (!outcome) return nullptr;
  const bool both_failed = !std::isfinite(outcome->loss) && !std::isfinite(again.loss);
  const bool same = std::bit_cast<std::uint64_t>(outcome->loss) == std::bit_cast<std::uint64_t>(again.loss);
  return (same || both_failed) && outcome->success == again.success;
}

// "replays", and what belongs to them: "bodies", "gravity", "fixed_poses".
void AddReplays(const ReportSource& source, bool has_success, const std::function<void(int, int)>& progress,
                Json* page) {
  const std::vector<std::size_t> order = ChooseReplays(source, has_success);
  const int total = CountReplays(static_cast<std::int64_t>(order.size()));
  const double period = source.model->scene().rollout.horizon / kFrames;
  Json replays = Json::array();
  std::size_t bytes = 0;
  int done = 0;
  for (std::size_t k = 0; 2 * k < static_cast<std::size_t>(total) && bytes < kMostBytes; ++k) {
    for (const ReportedTest& test : source.tests) {
      const RolloutInput input = MakeInput(source, test, order[k]);
      const RecordedRollout rollout = source.model->Record(input, period);
      if (replays.empty()) {
        (*page)["bodies"] =
            MakeBodiesJson(*source.model, rollout.recording, MakeInput(source, source.tests[1], order[k]).theta);
        const Eigen::Vector3d& g = rollout.recording.gravity_W;
        (*page)["gravity"] = {g.x(), g.y(), g.z()};
        (*page)["fixed_poses"] = MakeFixedPosesJson(rollout.recording);
      }
      Json replay = MakeReplayJson(test, order[k], rollout, has_success);
      replay["same_bits"] = IsSame(test.outcomes[order[k]], rollout.output);
      bytes += replay.dump().size();
      replays.push_back(std::move(replay));
      ++done;
      if (progress) progress(done, total);
    }
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
  const bool has_success = source.model->scene().success.has_value();
  const bool is_note = source.loss_unit.starts_with('(');  // "(lengths in cm)" is no unit that stands behind a number
  const Json info = ReadJson(source.run->info_path());
  const CsvTable rollouts(ReadFile(source.run->rollouts_path()));
  Json data = {{"format", 1},
               {"knap", {{"version", info.value("version", "")}, {"build", info.value("build", "")}}},
               {"run", MakeRunJson(source, info, ReadJson(source.run->result_path()))},
               {"loss_unit", source.loss_unit.empty() || is_note ? Json() : Json(source.loss_unit)},
               {"loss_note", is_note ? Json(source.loss_unit) : Json()},
               {"has_success", has_success},
               {"theta", MakeThetaJson(source)},
               {"test", MakeTestJson(source, ReadJson(source.run->evaluation_path()))},
               {"variation", MakeVariationJson(source, has_success)}};
  AddReplays(source, has_success, progress, &data);
  data["learning"] = MakeLearningJson(*source.run);
  data["timeline"] = MakeTimelineJson(*source.run, rollouts);
  data["certificates"] = MakeCertificatesJson(rollouts);
  data["repeat"] = MakeRepeatJson(source);
  return MakePage(data);
}

}  // namespace knap
