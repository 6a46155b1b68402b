#include "coordinator/run_directory/result_document.h"

#include <cmath>
#include <stdexcept>
#include <utility>

namespace knap {
namespace {

using Json = nlohmann::ordered_json;

// The figures of the loss are null together where no rollout had a finite one.
Json MakeLossFigure(const TestSummary& test, const Json& figure) {
  return std::isinf(test.loss_mean) ? Json() : figure;
}

Json MakeFigures(const TestSummary& test, bool has_success) {
  return {{"loss_mean", MakeLossFigure(test, test.loss_mean)},
          {"loss_std", MakeLossFigure(test, test.loss_std)},
          {"success_rate", has_success ? Json(test.success_rate) : Json()}};
}

}  // namespace

Json MakeResultJson(const ResultDocument& document) {
  const ParameterSpec& parameters = document.parameters;
  if (document.learned.size() != parameters.names.size()) {
    throw std::invalid_argument("result: " + std::to_string(document.learned.size()) + " learned values for " +
                                std::to_string(parameters.names.size()) + " parameters");
  }
  if (document.test_initial.variations != document.test_learned.variations ||
      document.test_initial.seed != document.test_learned.seed) {
    throw std::invalid_argument("result: the initial and the learned design were tested on different variations");
  }
  return {{"schema", 1},
          {"scenario", document.scenario},
          {"method", document.method},
          {"seed", document.seed},
          {"theta",
           {{"names", parameters.names},
            {"lower", parameters.lower},
            {"upper", parameters.upper},
            {"initial", parameters.initial},
            {"learned", document.learned}}},
          {"test",
           {{"variations", document.test_learned.variations},
            {"seed", document.test_learned.seed},
            {"initial", MakeFigures(document.test_initial, document.has_success)},
            {"learned", MakeFigures(document.test_learned, document.has_success)}}},
          {"rollouts",
           {{"total", document.rollouts_total},
            {"distinct", document.rollouts_distinct},
            {"reissued", document.rollouts_reissued ? Json(*document.rollouts_reissued) : Json()}}},
          {"wall_s", document.wall_s}};
}

Json MakeEvaluationJson(const TestSummary& summary, bool has_success) {
  Json json = {{"variations", summary.variations}, {"seed", summary.seed}};
  json.update(MakeFigures(summary, has_success));
  json["loss_mean_95"] = MakeLossFigure(summary, {summary.loss_interval.lower, summary.loss_interval.upper});
  json["success_rate_95"] = has_success ? Json{summary.success_interval.lower, summary.success_interval.upper} : Json();
  json["worst_decile_loss"] = MakeLossFigure(summary, summary.worst_decile_loss);
  json["not_converged"] = summary.not_converged;
  json["not_finite"] = summary.not_finite;
  json["untrusted"] = summary.untrusted;
  json["distrust"] = summary.untrusted > 0 ? Json(summary.distrust) : Json();
  return json;
}

Json MakeEvaluationsJson(const ResultDocument& document) {
  Json validations = Json::array();
  for (const BatchValidation& validation : document.validations) {
    Json json = {{"batch", validation.batch}};
    json.update(MakeEvaluationJson(validation.test, document.has_success));
    validations.push_back(std::move(json));
  }
  return {{"initial", MakeEvaluationJson(document.test_initial, document.has_success)},
          {"learned", MakeEvaluationJson(document.test_learned, document.has_success)},
          {"clearly_better", IsClearlyBetter(document.test_learned, document.test_initial)},
          {"learned_batch", document.batch},
          {"validation", std::move(validations)}};
}

}  // namespace knap
