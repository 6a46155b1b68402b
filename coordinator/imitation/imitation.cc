#include "coordinator/imitation/imitation.h"

#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <utility>

#include "coordinator/optimizer/bounded_minimizer.h"

namespace knap {
namespace {

using Eigen::VectorXd;

void CheckSizes(const Network& network, const Examples& examples, std::size_t weights) {
  const auto require = [](std::size_t have, std::size_t want, const char* what) {
    if (have == want) return;
    throw std::invalid_argument("imitation: " + std::to_string(have) + " " + what + "; expected " +
                                std::to_string(want));
  };
  require(weights, static_cast<std::size_t>(network.num_weights()), "weights");
  require(examples.wanted.size(), examples.seen.size(), "examples with commands");
  if (examples.seen.empty()) throw std::invalid_argument("imitation: no example; at least one is needed");
  for (const VectorXd& x : examples.seen) {
    require(static_cast<std::size_t>(x.size()), static_cast<std::size_t>(network.num_inputs()), "numbers seen");
  }
  for (const VectorXd& y : examples.wanted) {
    require(static_cast<std::size_t>(y.size()), static_cast<std::size_t>(network.num_outputs()), "commands");
  }
}

// The mean square error and its gradient in the weights.
ObjectiveValue CalcError(Network& network, const Examples& examples, const std::vector<double>& weights) {
  const VectorXd w = Eigen::Map<const VectorXd>(weights.data(), static_cast<Eigen::Index>(weights.size()));
  const double share = 1.0 / (static_cast<double>(examples.seen.size()) * network.num_outputs());
  VectorXd bar_w = VectorXd::Zero(network.num_weights());
  VectorXd bar_x = VectorXd::Zero(network.num_inputs());  // of no interest
  VectorXd bar_y(network.num_outputs());
  double sum = 0.0;
  for (std::size_t i = 0; i < examples.seen.size(); ++i) {
    const VectorXd& y = network.Calc(w, examples.seen[i]);
    for (Eigen::Index k = 0; k < y.size(); ++k) {
      const double e = y(k) - examples.wanted[i](k);
      sum += e * e;
      bar_y(k) = 2.0 * share * e;
    }
    network.PullBack(w, examples.seen[i], bar_y, &bar_w, &bar_x);
  }
  return {.value = share * sum, .gradient = {bar_w.begin(), bar_w.end()}};
}

}  // namespace

Imitation Imitate(Network network, const Examples& examples, std::vector<double> start,
                  const ImitationOptions& options) {
  CheckSizes(network, examples, start.size());
  const auto error = [&](const std::vector<double>& w) { return CalcError(network, examples, w); };
  MinimizerProblem problem;
  problem.lower.assign(start.size(), options.lower);
  problem.upper.assign(start.size(), options.upper);
  problem.scale.assign(start.size(), options.upper - options.lower);
  problem.start_value = error(start);
  problem.start = std::move(start);
  // The error of data without noise falls to zero: only evaluations, and steps that no longer count, end the search.
  const MinimizerOptions minimizer{
      .max_evaluations = options.max_evaluations, .value_tolerance = 1e-8, .step_tolerance = 1e-10, .first_step = 0.01};
  const MinimizerResult minimum = Minimize(EachAlone(error), problem, minimizer);
  return {.weights = minimum.x,
          .start_error = std::sqrt(problem.start_value.value),
          .error = std::sqrt(minimum.value),
          .evaluations = minimum.evaluations};
}

}  // namespace knap
