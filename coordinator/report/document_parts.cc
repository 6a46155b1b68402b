#include "coordinator/report/document_parts.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "coordinator/report/replay_json.h"
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

constexpr double kFrames = 120.0;  // of a replay

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

}  // namespace

Json MakeHeadJson(const ReportSource& source, const Json& result) {
  const bool is_note = source.loss_unit.starts_with('(');  // "(lengths in cm)" is no unit that stands behind a number
  const Json info = Json::parse(ReadFile(source.run->info_path()));
  return {{"format", 1},
          {"knap", {{"version", info.value("version", "")}, {"build", info.value("build", "")}}},
          {"run", MakeRunJson(source, info, result)},
          {"loss_unit", source.loss_unit.empty() || is_note ? Json() : Json(source.loss_unit)},
          {"loss_note", is_note ? Json(source.loss_unit) : Json()},
          {"has_success", source.model->scene().success.has_value()}};
}

Json MakeThetaJson(const ReportSource& source) {
  const ParameterSpec& parameters = source.problem->parameters;
  Json theta = MakeBoundsJson(parameters);
  theta["initial"] = TakeDesign(parameters, source.tests[0].theta);
  theta["learned"] = TakeDesign(parameters, source.tests[1].theta);
  return theta;
}

Json MakeVariationJson(const ReportSource& source) {
  const bool has_success = source.model->scene().success.has_value();
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

Json RecordReplayJson(const ReportSource& source, const ReportedTest& test, std::size_t variation, Json* page) {
  const double period = source.model->scene().rollout.horizon / kFrames;
  const RecordedRollout rollout = source.model->Record(MakeInput(source, test, variation), period);
  if (!page->contains("bodies")) {
    (*page)["bodies"] =
        MakeBodiesJson(*source.model, rollout.recording, MakeInput(source, source.tests[1], variation).theta);
    const Eigen::Vector3d& g = rollout.recording.gravity_W;
    (*page)["gravity"] = {g.x(), g.y(), g.z()};
    (*page)["fixed_poses"] = MakeFixedPosesJson(rollout.recording);
  }
  Json replay = MakeReplayJson(test, variation, rollout, source.model->scene().success.has_value());
  replay["same_bits"] = IsSame(test.outcomes[variation], rollout.output);
  return replay;
}

}  // namespace knap
