// A rollout service whose losses are closed forms, for tests of the schedule.
//
//   task loss    sum_i w_i (theta_i - c_i - v_i)²       v: the variation, d values
//   distillation sum_i (theta_i - theta_ref,i)²
//
// With v of mean 0 the expected task loss is least at theta = c.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include "coordinator/rollout_service.h"

namespace knap {

class QuadraticService : public RolloutService {
 public:
  QuadraticService(std::vector<double> weights, std::vector<double> optimum)
      : weights_(std::move(weights)), optimum_(std::move(optimum)) {}

  std::vector<RolloutOutcome> Evaluate(std::span<const RolloutQuery> queries) override {
    calls.emplace_back(queries.begin(), queries.end());
    std::vector<RolloutOutcome> outcomes;
    for (const RolloutQuery& query : queries) {
      outcomes.push_back(Answer(query));
      if (spoil) spoil(query, outcomes.back());
    }
    return outcomes;
  }

  std::function<void(const RolloutQuery&, RolloutOutcome&)> spoil;  // changes an answer, if set
  std::vector<std::vector<RolloutQuery>> calls;                     // all that was asked

 private:
  // A problem without variation has none.
  static double GetShift(const RolloutQuery& query, std::size_t i) {
    return query.variation.empty() ? 0.0 : query.variation[i];
  }

  RolloutOutcome Answer(const RolloutQuery& query) const {
    RolloutOutcome outcome;
    outcome.certificate = {.finite = true, .converged = true, .gradient_reliable = true};
    for (std::size_t i = 0; i < query.theta.size(); ++i) {
      const bool task = query.theta_reference.empty();
      const double weight = task ? weights_[i] : 1.0;
      const double error = query.theta[i] - (task ? optimum_[i] + GetShift(query, i) : query.theta_reference[i]);
      outcome.loss += weight * error * error;
      if (query.gradient) outcome.gradient.push_back(2.0 * weight * error);
    }
    outcome.success = outcome.loss < 0.1;
    return outcome;
  }

  std::vector<double> weights_, optimum_;
};

}  // namespace knap
