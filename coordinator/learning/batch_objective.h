// The loss of one batch and its gradient [paper §IV.B; docs/method.md]:
//
//   L(theta) = 1/|B| sum_{i in B} loss(theta; T_i)  +  alpha/|D| sum_{i in D} distill(theta, theta_ref; T_i)
//
// B is the batch, D the distillation set (may be empty: then the second term is 0), theta_ref = theta_{t-1}. Sums run
// in index order, so the bits do not depend on which worker answered first.
//
// Trust. A rollout is trusted when its certificate says finite and converged. What an untrusted one says is never used:
//  - At the start, theta_ref, a variation whose rollout is not trusted is not asked again until the batch ends, so that
//    one hopeless variation does not stop the learning and L stays one fixed function. In the task term it counts all
//    the same, with the constant that is the worst trusted loss at theta_ref, so that the loss of a batch with failures
//    is no better than that of its worst rollout. The distillation term is the mean over the rest of D.
//  - Later, one untrusted rollout rejects the whole evaluation: the optimizer retreats (see bounded_minimizer.h) and
//    keeps the best trusted point. Dropping the rollout instead would change L between points and reward designs that
//    break the simulator.
// Both are counted, and the run reports the counts.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "coordinator/rollout_service.h"

namespace knap {

struct BatchEvaluation {
  std::vector<double> theta{};     // d
  bool accepted = false;           // every rollout was trusted and L is finite; false: these four are +infinity:
  double loss = 0.0;               // L
  double task_loss = 0.0;          // the first term
  double distillation_loss = 0.0;  // the second term without alpha
  double gradient_norm = 0.0;      // |dL/dtheta|_2 in range-normalised parameters; 0 when no gradient was asked for
  std::vector<double> gradient{};  // dL/dtheta, d values; empty when rejected or not asked for
  int rollouts = 0;                // asked for this evaluation
  int successes = 0;               // trusted task rollouts that succeeded
  int untrusted = 0;               // rollouts that were not finite or not converged
  int doubtful_gradients = 0;      // trusted rollouts whose gradient is not reliable (used all the same)
};

class BatchObjective {
 public:
  // task, distillation: the variations' values, in index order; task not empty. range: d values > 0, upper - lower,
  // used for gradient_norm alone. range and service must outlive the object.
  BatchObjective(std::vector<std::vector<double>> task, std::vector<std::vector<double>> distillation,
                 std::vector<double> theta_reference, std::span<const double> range, double alpha,
                 RolloutService& service);

  // L at theta_ref with its gradient, and the exclusion of untrusted variations (call it once, first). The distillation
  // term is zero there and has zero gradient by definition; its rollouts run without gradient, for their certificates
  // alone. Rejected when no task variation is left.
  BatchEvaluation EvaluateStart();

  // L at each theta, all asked for at once; with_gradient false leaves the gradients empty.
  std::vector<BatchEvaluation> Evaluate(std::span<const std::vector<double>> thetas, bool with_gradient);

  // Rollouts that the next evaluation asks for.
  int evaluation_rollouts() const { return static_cast<int>(task_.size() + distillation_.size()); }

  int excluded_task() const { return excluded_task_; }
  int excluded_distillation() const { return excluded_distillation_; }

 private:
  BatchEvaluation Sum(const std::vector<double>& theta, std::span<const RolloutOutcome> outcomes,
                      bool with_gradient) const;
  void Finish(BatchEvaluation& evaluation) const;  // gradient_norm and accepted
  double count_task() const { return static_cast<double>(task_.size()) + excluded_task_; }  // |B|

  std::vector<std::vector<double>> task_;
  std::vector<std::vector<double>> distillation_;
  std::vector<double> theta_reference_;
  std::span<const double> range_;
  double alpha_;
  RolloutService& service_;
  int excluded_task_ = 0;
  int excluded_distillation_ = 0;
  double excluded_loss_ = 0.0;  // with which the excluded variations count together, whatever theta
};

// True when the outcome may be used: finite and converged, by its certificate and by its own numbers. Throws
// std::runtime_error when the gradient has not `gradient_size` values (0: none was asked for).
bool IsTrusted(const RolloutOutcome& outcome, std::size_t gradient_size);

// Asks the service and checks that it answered every query; throws std::runtime_error otherwise.
std::vector<RolloutOutcome> EvaluateAll(RolloutService& service, std::span<const RolloutQuery> queries);

}  // namespace knap
