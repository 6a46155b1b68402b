// Learns theta over a sequence of batches of task variations [paper §IV.B and Baselines of §V; docs/method.md].
//
// Methods, for batches t = 1 … T of M training variations each (T = ceil(N/M), variation indices in order):
//  ours              theta_t = argmin L_task + alpha L_distill over the chosen d' dimensions (dimension_selection.h) in
//                    the box |theta_i - theta_{t-1,i}| <= rate · (upper_i - lower_i), intersected with the bounds. D is
//                    M variations drawn without replacement from all earlier batches, fixed during the batch; empty at
//                    t = 1, and when alpha = 0.
//  simple_continual  theta_t = argmin L_task over all dimensions in the full bounds.
//                    (Parameters that are fixed never move, whatever the method.)
//  diffhand          T = 1; a batch B_0 of M variations from a stream of its own; otherwise as simple_continual.
//
// Every batch starts with one evaluation at theta_{t-1}: it gives the gradient that chooses the dimensions (that of the
// batch's task loss: the distillation term is zero there and has zero gradient) and is the optimizer's first point.
// theta_t is the best accepted point evaluated, so the batch's loss never rises over its start.
//
// The next batch may undo what one has learned, so theta_0 and every theta_t are tried on validation variations, the
// same for all, and the best of them is what is learned; the batches themselves go on from theta_t.
//
// Evaluations allowed for a batch, its start included: without a rollout budget max_evaluations, and for diffhand T' ·
// max_evaluations with the T' = ceil(N/M) of the continual methods. With a budget R: floor(r / b / c), but at least 2,
// r rollouts and b batches being left and c the rollouts of one evaluation; learning ends when r < 2c.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "coordinator/learning/batch_objective.h"
#include "coordinator/learning/evaluation.h"
#include "coordinator/learning/learning_options.h"
#include "coordinator/learning/problem.h"
#include "coordinator/rollout_service.h"

namespace knap {

struct BatchStart {
  int batch = 0;                              // t, from 1
  int batches = 0;                            // T
  std::vector<std::uint64_t> variations{};    // indices in the stream of training variations (diffhand: of B_0), rising
  std::vector<std::uint64_t> distillation{};  // indices of training variations, rising
  std::vector<double> theta{};                // theta_{t-1}
  int max_evaluations = 0;
};

// What moves in the batch; follows the evaluation at the start.
struct BatchBox {
  int batch = 0;
  std::vector<std::size_t> dimensions{};  // in order of choice; empty: nothing moves
  double radius = 0.0;                    // half width over each parameter's range; 1 for the baselines (full bounds)
  bool restarted = false;
  std::vector<double> lower, upper;  // d each; equal to theta_{t-1} where nothing moves
  int excluded_task = 0;             // variations whose rollout at the start was not to be trusted
  int excluded_distillation = 0;
};

struct LearningEvaluation {
  int batch = 0;
  int evaluation = 0;  // from 0, the start
  BatchEvaluation value{};
  double best_loss = 0.0;     // of the batch, this evaluation included; +infinity while none was accepted
  std::int64_t rollouts = 0;  // of the whole learning, this evaluation included
};

enum class BatchStop {
  kConverged,       // a tolerance of the optimizer
  kEvaluations,     // all allowed evaluations used
  kStalled,         // the optimizer found no further progress
  kFlat,            // zero gradient at the start: nothing to move
  kNothingTrusted,  // no rollout at the start was to be trusted: theta stays
};
const char* GetName(BatchStop stop);

struct BatchEnd {
  int batch = 0;
  std::vector<double> theta{};               // theta_t
  double start_loss = 0.0, best_loss = 0.0;  // +infinity for kNothingTrusted
  int evaluations = 0;
  int rejected = 0;  // evaluations not accepted
  BatchStop stop = BatchStop::kConverged;
};

// theta_t on the validation variations; t = 0: the initial design.
struct BatchValidation {
  int batch = 0;
  TestSummary test{};
  bool is_best = false;  // of those so far
};

// Called from Learn's own thread, in this order: validation of the initial design; for each batch start, evaluation 0,
// box, evaluations 1 …, end, validation. An exception thrown here ends the learning and comes out of Learn.
class LearningObserver {
 public:
  virtual ~LearningObserver() = default;
  virtual void OnBatchStart(const BatchStart& start) = 0;
  virtual void OnEvaluation(const LearningEvaluation& evaluation) = 0;
  virtual void OnBatchBox(const BatchBox& box) = 0;
  virtual void OnBatchEnd(const BatchEnd& end) = 0;
  // Around the rollouts of a validation; most have no use for them.
  virtual void OnValidationStart() {}
  virtual void OnValidation(const BatchValidation&) {}
};

struct LearningResult {
  std::vector<double> theta;                 // that of the best validation, or the last
  int batch = 0;                             // whose it is; 0: the initial design's
  std::vector<BatchValidation> validations;  // of theta_0 … theta_T, or none
  std::vector<BatchEnd> batches;             // fewer than T when the budget ended first
  std::int64_t evaluations = 0;
  std::int64_t rejected = 0;   // evaluations
  std::int64_t rollouts = 0;   // without those of validation
  std::int64_t untrusted = 0;  // rollouts, the excluded ones included
  std::int64_t excluded = 0;   // variations excluded from a batch or a distillation set
  std::int64_t doubtful_gradients = 0;
  int restarts = 0;
  bool budget_exhausted = false;  // the budget ended before the last batch
};

// A pure function of its arguments as long as the service is: same bits for any number of workers. Throws
// std::invalid_argument for a bad problem or bad options, and passes on what the service or the observer throws.
LearningResult Learn(const Problem& problem, const LearningOptions& options, RolloutService& service,
                     LearningObserver& observer);

}  // namespace knap
