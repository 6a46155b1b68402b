// The hyperparameters of learning. [paper §IV and Table I of its appendix; docs/method.md]
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

namespace knap {

enum class LearningMethod {
  kOurs,             // distillation, d' dimensions a batch, a shrinking box
  kSimpleContinual,  // task loss alone, all dimensions, full bounds, batch after batch
  kDiffHand,         // one batch B_0 of its own, task loss alone, all dimensions, full bounds, to convergence
};

// "ours", "simple_continual", "diffhand".
const char* GetName(LearningMethod method);
// Throws std::invalid_argument that lists the names allowed.
LearningMethod ParseLearningMethod(const std::string& name);

struct LearningOptions {
  LearningMethod method = LearningMethod::kOurs;
  int variations = 100;          // N, training variations; >= 1
  int batch = 5;                 // M, variations of a batch and of the distillation set; 1 … N
  int dimensions_per_batch = 2;  // d', 1 … d
  double alpha = 0.1;            // weight of the distillation loss; >= 0
  double learning_rate = 0.25;   // half width of the box around theta_{t-1} over each parameter's range; (0, 1]
  double learning_rate_decay = 0.36787944117144233;  // e^-1: factor on the learning rate at each restart; (0, 1]

  std::string optimizer = "LD_LBFGS";  // as CheckMinimizerAlgorithm allows
  int max_evaluations = 20;            // of the batch loss for one batch, the start included; >= 2
  double loss_tolerance = 1e-4;        // a batch ends when its loss changes relatively by less [-]; >= 0
  double parameter_tolerance = 1e-4;   // … or every parameter by less than this part of its range [-]; >= 0
  double first_step = 0.25;            // first step over the widest side of the box [-]; (0, 1]

  // After every batch the design is tried on so many variations of a stream of its own; 0: never. What is learned is
  // the best of the initial design and all batches' then (evaluation.h), or the last one [paper].
  int validation = 0;
  bool keep_best = true;

  // At most this many rollouts of learning, those of validation left out, so that methods can be compared at equal
  // numbers: give the baselines what `ours` used. Then each batch may use an equal share of what the batches before it
  // left, in place of max_evaluations.
  std::optional<std::int64_t> rollout_budget;

  std::uint64_t seed = 0;
};

// The number of batches: ceil(N / M), the last one possibly short; 1 for diffhand.
int CalcBatchCount(const LearningOptions& options);

// `dimensions` is d. Throws std::invalid_argument naming the option, its value and what is allowed.
void CheckLearningOptions(const LearningOptions& options, std::size_t dimensions);

}  // namespace knap
