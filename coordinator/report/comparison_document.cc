#include "coordinator/report/comparison_document.h"

#include <cstddef>
#include <utility>

#include "coordinator/report/report_page.h"
#include "coordinator/report/theta_json.h"
#include "coordinator/run_directory/durable_file.h"
#include "coordinator/run_directory/json_text.h"
#include "sim/scenarios/csv_text.h"

namespace knap {
namespace {

using Json = nlohmann::ordered_json;

Json MakeCurveJson(const std::filesystem::path& path) {
  const CsvTable metrics(ReadFile(path));
  Json curve = Json::object();
  for (const char* name : {"rollouts", "best_loss", "validation_loss", "validation_success"}) {
    Json column = Json::array();
    for (std::size_t i = 0; i < metrics.size(); ++i) column.push_back(MakeJsonNumber(metrics.GetNumber(i, name)));
    curve[name] = std::move(column);
  }
  return curve;
}

}  // namespace

std::string MakeComparisonPage(const Comparison& comparison) {
  const ParameterSpec& parameters = comparison.problem->parameters;
  Json groups = Json::array();
  for (const ComparedGroup& group : comparison.groups) {
    Json runs = Json::array();
    for (const ComparedRun& run : group.runs) {
      runs.push_back({{"name", run.name},
                      {"rollouts", run.rollouts},
                      {"theta", TakeDesign(parameters, run.theta)},
                      {"test", run.test},
                      {"curve", MakeCurveJson(run.metrics)}});
    }
    groups.push_back({{"name", group.name}, {"runs", std::move(runs)}});
  }
  const bool is_note = comparison.loss_unit.starts_with('(');
  Json data = {
      {"format", 1},
      {"knap", comparison.build},
      {"run", comparison.run},
      {"loss_unit", comparison.loss_unit.empty() || is_note ? Json() : Json(comparison.loss_unit)},
      {"loss_note", is_note ? Json(comparison.loss_unit) : Json()},
      {"has_success", comparison.has_success},
      {"theta", MakeBoundsJson(parameters)},
      {"comparison", {{"initial", comparison.initial}, {"of_runs", comparison.of_runs}, {"groups", std::move(groups)}}},
      {"repeat", comparison.repeat}};
  data["theta"]["initial"] = TakeDesign(parameters, parameters.initial);
  return MakePage(data);
}

}  // namespace knap
