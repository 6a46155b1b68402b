#include "coordinator/landscape/landscape.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <stdexcept>
#include <utility>

#include "coordinator/learning/batch_objective.h"
#include "coordinator/learning/failed_rollouts.h"

namespace knap {
namespace {

void CheckPlan(const LandscapePlan& plan) {
  const std::size_t d = plan.theta.size();
  if (plan.x.parameter >= d || plan.y.parameter >= d || plan.x.parameter == plan.y.parameter) {
    throw std::invalid_argument(fmt::format("landscape: parameters {} and {} of {}; expected two different ones",
                                            plan.x.parameter, plan.y.parameter, d));
  }
  if (plan.x.values.size() < 2 || plan.y.values.size() < 2 || plan.variations.empty()) {
    throw std::invalid_argument(fmt::format("landscape: {} by {} cells and {} variations; expected 2, 2 and 1 or more",
                                            plan.x.values.size(), plan.y.values.size(), plan.variations.size()));
  }
}

LandscapeCell MakeCell(std::span<const RolloutOutcome> outcomes) {
  LandscapeCell cell;
  int successes = 0;
  for (const RolloutOutcome& outcome : outcomes) {
    cell.subdivided_steps += outcome.certificate.subdivided_steps;
    if (!std::isfinite(outcome.loss) || !outcome.certificate.finite) {
      ++cell.not_finite;
      continue;
    }
    cell.worst_residual = std::max(cell.worst_residual, outcome.certificate.worst_residual);
    cell.not_converged += outcome.certificate.converged ? 0 : 1;
    successes += outcome.certificate.converged && outcome.success ? 1 : 0;
  }
  double sum = 0.0;
  for (const double loss : CountLosses(outcomes)) sum += loss;
  cell.loss = sum / static_cast<double>(outcomes.size());
  cell.success_rate = static_cast<double>(successes) / static_cast<double>(outcomes.size());
  return cell;
}

}  // namespace

LandscapeAxis MakeAxis(const ParameterSpec& parameters, std::size_t parameter, int count) {
  const double lower = parameters.lower[parameter], upper = parameters.upper[parameter];
  LandscapeAxis axis{parameter, {}};
  for (int k = 0; k < count; ++k) axis.values.push_back(lower + (upper - lower) * k / (count - 1));
  axis.values.back() = upper;
  return axis;
}

std::int64_t CalcRolloutCount(const LandscapePlan& plan) {
  return static_cast<std::int64_t>(plan.x.values.size() * plan.y.values.size() * plan.variations.size());
}

Landscape EvaluateLandscape(LandscapePlan plan, RolloutService& service) {
  CheckPlan(plan);
  std::vector<RolloutQuery> queries;
  RolloutQuery query{.theta = plan.theta, .theta_reference = {}, .variation = {}, .gradient = false};
  for (const double y : plan.y.values) {
    for (const double x : plan.x.values) {
      query.theta[plan.x.parameter] = x;
      query.theta[plan.y.parameter] = y;
      for (const std::vector<double>& variation : plan.variations) {
        query.variation = variation;
        queries.push_back(query);
      }
    }
  }
  const std::vector<RolloutOutcome> outcomes = EvaluateAll(service, queries);
  Landscape landscape{std::move(plan), {}};
  const std::size_t n = landscape.plan.variations.size();
  for (std::size_t first = 0; first < outcomes.size(); first += n) {
    landscape.cells.push_back(MakeCell(std::span(outcomes).subspan(first, n)));
  }
  return landscape;
}

std::string MakeLandscapeCsv(const Landscape& landscape, const ParameterSpec& parameters) {
  const LandscapePlan& plan = landscape.plan;
  std::string csv =
      fmt::format("{},{},loss,success_rate,variations,not_finite,not_converged,worst_residual,subdivided_steps\n",
                  parameters.names[plan.x.parameter], parameters.names[plan.y.parameter]);
  for (std::size_t i = 0; i < plan.y.values.size(); ++i) {
    for (std::size_t j = 0; j < plan.x.values.size(); ++j) {
      const LandscapeCell& cell = landscape.at(i, j);
      csv += fmt::format("{},{},{},{},{},{},{},{},{}\n", plan.x.values[j], plan.y.values[i], cell.loss,
                         cell.success_rate, plan.variations.size(), cell.not_finite, cell.not_converged,
                         cell.worst_residual, cell.subdivided_steps);
    }
  }
  return csv;
}

}  // namespace knap
