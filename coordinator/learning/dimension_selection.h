// Which parameters move in a batch, and how far: the paper's dimensionality reduction [paper §IV.B, "Simplifying
// Optimization with Dimensionality Reduction"; docs/method.md].
//
//   S_t = the d' dimensions i, not used since the last restart, with the largest |g_i|,
//         g_i = dL_task/dtheta_i (theta_{t-1}) · (upper_i - lower_i)
//
// Equal |g_i| go by index, the lower first. Dimensions in S_t then count as used. When fewer than d' are left, those
// alone move. When all have been used, all become available again (a restart) and the learning rate is multiplied by
// its decay.
//
// Zero gradients. A dimension with g_i = 0 is neither chosen nor marked as used: the batch says nothing about it. If g
// is zero altogether, nothing moves and nothing changes. If g is zero on all that is left but not on all that was used,
// every dimension that can lower this loss has been used, so this is a restart too; otherwise a parameter without any
// influence would never be used, the restart would never come, and learning would stand still for good.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace knap {

struct DimensionChoice {
  std::vector<std::size_t> dimensions{};  // in order of choice: falling |g|, ties by index; empty: nothing to move
  double learning_rate = 0.0;             // valid for this batch, after a restart's decay
  bool restarted = false;                 // this choice began with a restart
};

class DimensionSelection {
 public:
  // d dimensions, 1 <= dimensions_per_batch <= d, learning rate and decay in (0, 1].
  DimensionSelection(std::size_t dimensions, std::size_t dimensions_per_batch, double learning_rate, double decay);

  // Chooses for the next batch and marks the choice as used. normalised_gradient: d finite values g_i (see above).
  DimensionChoice Choose(std::span<const double> normalised_gradient);

  int restarts() const { return restarts_; }
  double learning_rate() const { return learning_rate_; }

 private:
  std::vector<bool> used_;
  std::size_t dimensions_per_batch_;
  double learning_rate_;
  double decay_;
  int restarts_ = 0;
};

}  // namespace knap
