// A network that does what examples do:
//
//   minimise over lower <= w_i <= upper    1/(n K) Σ_i Σ_k (network(w, x_i)_k − y_ik)²
//
// x_i: what is seen, y_i: K commands wanted then; n examples, all of them at every evaluation and summed in order, on
// one thread. L-BFGS over the bounds, so that the weights are a pure function of the arguments.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "sim/policy/network.h"

namespace knap {

struct Examples {
  std::vector<Eigen::VectorXd> seen;    // n of the network's inputs each
  std::vector<Eigen::VectorXd> wanted;  // n of its outputs each
};

struct ImitationOptions {
  double lower = -3.0, upper = 3.0;  // of every weight, lower < upper
  int max_evaluations = 3000;        // of the error and its gradient; >= 1
};

struct Imitation {
  std::vector<double> weights;
  double start_error = 0.0;  // root of the minimised mean, at the start and
  double error = 0.0;        // at the weights
  int evaluations = 0;
};

// From `start`, as many weights as the network has, within the bounds; at least one example. Throws
// std::invalid_argument when sizes do not fit.
Imitation Imitate(Network network, const Examples& examples, std::vector<double> start,
                  const ImitationOptions& options);

}  // namespace knap
