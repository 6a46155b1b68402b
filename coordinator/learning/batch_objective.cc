#include "coordinator/learning/batch_objective.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

namespace knap {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Sum of losses and gradients over rollouts in the order of adding.
struct LossSum {
  double loss = 0.0;
  std::vector<double> gradient;

  void Add(const RolloutOutcome& outcome) {
    loss += outcome.loss;
    if (gradient.empty()) gradient.assign(outcome.gradient.size(), 0.0);
    for (std::size_t i = 0; i < outcome.gradient.size(); ++i) gradient[i] += outcome.gradient[i];
  }
};

void Reject(BatchEvaluation& evaluation) {
  evaluation.accepted = false;
  evaluation.loss = evaluation.task_loss = evaluation.distillation_loss = evaluation.gradient_norm = kInfinity;
  evaluation.gradient.clear();
}

}  // namespace

bool IsTrusted(const RolloutOutcome& outcome, std::size_t gradient_size) {
  if (!outcome.certificate.finite || !outcome.certificate.converged || !std::isfinite(outcome.loss)) return false;
  if (outcome.gradient.size() != gradient_size) {
    throw std::runtime_error("a rollout answered with a gradient of " + std::to_string(outcome.gradient.size()) +
                             " values; expected " + std::to_string(gradient_size));
  }
  return std::all_of(outcome.gradient.begin(), outcome.gradient.end(), [](double g) { return std::isfinite(g); });
}

std::vector<RolloutOutcome> EvaluateAll(RolloutService& service, std::span<const RolloutQuery> queries) {
  std::vector<RolloutOutcome> outcomes = service.Evaluate(queries);
  if (outcomes.size() != queries.size()) {
    throw std::runtime_error("the rollout service answered " + std::to_string(outcomes.size()) + " of " +
                             std::to_string(queries.size()) + " queries");
  }
  return outcomes;
}

BatchObjective::BatchObjective(std::vector<std::vector<double>> task, std::vector<std::vector<double>> distillation,
                               std::vector<double> theta_reference, std::span<const double> range, double alpha,
                               RolloutService& service)
    : task_(std::move(task)),
      distillation_(std::move(distillation)),
      theta_reference_(std::move(theta_reference)),
      range_(range),
      alpha_(alpha),
      service_(service) {}

void BatchObjective::Finish(BatchEvaluation& evaluation) const {
  double sum = 0.0;
  for (std::size_t i = 0; i < evaluation.gradient.size(); ++i) {
    sum += (evaluation.gradient[i] * range_[i]) * (evaluation.gradient[i] * range_[i]);
  }
  evaluation.gradient_norm = std::sqrt(sum);
  evaluation.accepted = std::isfinite(evaluation.loss) && std::isfinite(evaluation.gradient_norm);
  if (!evaluation.accepted) Reject(evaluation);  // finite rollouts may still add up to an overflow
}

BatchEvaluation BatchObjective::EvaluateStart() {
  const std::size_t d = theta_reference_.size();
  std::vector<RolloutQuery> queries;
  for (const auto& variation : task_) queries.push_back({theta_reference_, {}, variation, true});
  for (const auto& variation : distillation_) queries.push_back({theta_reference_, theta_reference_, variation, false});
  const std::vector<RolloutOutcome> outcomes = EvaluateAll(service_, queries);

  BatchEvaluation evaluation{.theta = theta_reference_, .rollouts = static_cast<int>(queries.size())};
  std::vector<std::vector<double>> trusted_task, trusted_distillation;
  LossSum task;
  double worst = -kInfinity;
  for (std::size_t i = 0; i < task_.size(); ++i) {
    if (!IsTrusted(outcomes[i], d)) continue;
    trusted_task.push_back(task_[i]);
    task.Add(outcomes[i]);
    worst = std::max(worst, outcomes[i].loss);
    evaluation.successes += outcomes[i].success ? 1 : 0;
    evaluation.doubtful_gradients += outcomes[i].certificate.gradient_reliable ? 0 : 1;
  }
  for (std::size_t i = 0; i < distillation_.size(); ++i) {
    if (IsTrusted(outcomes[task_.size() + i], 0)) trusted_distillation.push_back(distillation_[i]);
  }
  excluded_task_ = static_cast<int>(task_.size() - trusted_task.size());
  excluded_distillation_ = static_cast<int>(distillation_.size() - trusted_distillation.size());
  evaluation.untrusted = excluded_task_ + excluded_distillation_;
  task_ = std::move(trusted_task);
  distillation_ = std::move(trusted_distillation);
  if (task_.empty()) {
    Reject(evaluation);
    return evaluation;
  }
  if (excluded_task_ > 0) excluded_loss_ = excluded_task_ * worst;
  evaluation.loss = evaluation.task_loss = (task.loss + excluded_loss_) / count_task();
  for (double& value : task.gradient) value /= count_task();
  evaluation.gradient = std::move(task.gradient);
  Finish(evaluation);
  return evaluation;
}

std::vector<BatchEvaluation> BatchObjective::Evaluate(std::span<const std::vector<double>> thetas, bool with_gradient) {
  std::vector<RolloutQuery> queries;
  for (const std::vector<double>& theta : thetas) {
    for (const auto& variation : task_) queries.push_back({theta, {}, variation, with_gradient});
    for (const auto& variation : distillation_) queries.push_back({theta, theta_reference_, variation, with_gradient});
  }
  const std::vector<RolloutOutcome> outcomes = EvaluateAll(service_, queries);
  const auto each = static_cast<std::size_t>(evaluation_rollouts());
  std::vector<BatchEvaluation> evaluations;
  for (std::size_t i = 0; i < thetas.size(); ++i) {
    evaluations.push_back(Sum(thetas[i], std::span(outcomes).subspan(i * each, each), with_gradient));
  }
  return evaluations;
}

BatchEvaluation BatchObjective::Sum(const std::vector<double>& theta, std::span<const RolloutOutcome> outcomes,
                                    bool with_gradient) const {
  BatchEvaluation evaluation{.theta = theta, .rollouts = static_cast<int>(outcomes.size())};
  LossSum task, distillation;
  for (std::size_t i = 0; i < outcomes.size(); ++i) {
    if (!IsTrusted(outcomes[i], with_gradient ? theta.size() : 0)) {
      ++evaluation.untrusted;
      continue;
    }
    const bool is_task = i < task_.size();
    (is_task ? task : distillation).Add(outcomes[i]);
    evaluation.successes += is_task && outcomes[i].success ? 1 : 0;
    evaluation.doubtful_gradients += with_gradient && !outcomes[i].certificate.gradient_reliable ? 1 : 0;
  }
  if (evaluation.untrusted > 0) {
    Reject(evaluation);
    return evaluation;
  }
  evaluation.task_loss = (task.loss + excluded_loss_) / count_task();
  if (!distillation_.empty()) {
    evaluation.distillation_loss = distillation.loss / static_cast<double>(distillation_.size());
  }
  evaluation.loss = evaluation.task_loss + alpha_ * evaluation.distillation_loss;
  if (with_gradient) {
    evaluation.gradient.resize(theta.size());
    for (std::size_t i = 0; i < theta.size(); ++i) {
      evaluation.gradient[i] = task.gradient[i] / count_task();
      if (!distillation_.empty()) {
        evaluation.gradient[i] += alpha_ * (distillation.gradient[i] / static_cast<double>(distillation_.size()));
      }
    }
  }
  Finish(evaluation);
  return evaluation;
}

}  // namespace knap
