// A two-dimensional slice of the loss: two parameters take every value of a grid, all others stay.
//
//   f(x_j, y_i) = 1/n sum_k loss(theta with theta_a = x_j, theta_b = y_i; T_k),   k = 0 … n-1
//
// Sums run in index order, so the figures do not depend on who answered first. Failed rollouts count as
// everywhere (failed_rollouts.h): a cell's figures are those that `knap evaluate` gives for its design.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "coordinator/learning/problem.h"
#include "coordinator/rollout_service.h"

namespace knap {

struct LandscapeAxis {
  std::size_t parameter = 0;   // index in theta
  std::vector<double> values;  // rising, two or more
};

// `count` >= 2 values from the parameter's lower to its upper bound, both exactly.
LandscapeAxis MakeAxis(const ParameterSpec& parameters, std::size_t parameter, int count);

struct LandscapePlan {
  LandscapeAxis x, y;                           // of different parameters
  std::vector<double> theta;                    // d values, those of all other parameters
  std::vector<std::vector<double>> variations;  // n >= 1
};

struct LandscapeCell {
  double loss = 0.0;          // mean; infinite when no rollout of the cell has a finite loss
  double success_rate = 0.0;  // of all n; a rollout that is not converged or not finite never counts as a success
  int not_finite = 0;         // rollouts without a finite loss
  int not_converged = 0;      // rollouts with a finite loss whose certificate says not converged
  double worst_residual = 0.0;
  int subdivided_steps = 0;  // sum over the rollouts
};

struct Landscape {
  LandscapePlan plan;
  std::vector<LandscapeCell> cells;  // row by row: cell (x_j, y_i) at i * x.values.size() + j

  const LandscapeCell& at(std::size_t i, std::size_t j) const { return cells[i * plan.x.values.size() + j]; }
};

// Cells times variations.
std::int64_t CalcRolloutCount(const LandscapePlan& plan);

// All rollouts in one call of the service, so that no worker idles between cells, without gradients. Throws
// std::invalid_argument for a plan that is none, and what the service throws.
Landscape EvaluateLandscape(LandscapePlan plan, RolloutService& service);

// Columns: the two parameters by name, loss, success_rate, variations, not_finite, not_converged, worst_residual,
// subdivided_steps; SI, in the shortest form that reads back to the same bits; one row a cell, x fastest.
std::string MakeLandscapeCsv(const Landscape& landscape, const ParameterSpec& parameters);

}  // namespace knap
