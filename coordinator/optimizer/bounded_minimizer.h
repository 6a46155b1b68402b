// Minimises a function over a box with any of NLopt's algorithms, or with an evolution strategy
// (evolution_strategy.h), and always returns the best point it saw.
//
//   minimise f(x)   subject to   lower_i <= x_i <= upper_i
//
// NLopt works on z_i = (x_i - start_i) / scale_i, so that steps and tolerances mean the same fraction of every
// parameter's range, and z = 0 is the start to the last bit.
//
// The first step. NLopt's LD_LBFGS (Luksan's PLIS) begins with the step -df/dz as it stands, cut at the first bound it
// meets; nlopt_set_initial_step has no effect on it. A loss in large units would then always jump to the edge of the
// box, and one in small units would not move. So the objective is multiplied by one positive constant, chosen such that
// this first step moves the steepest coordinate that can move by `first_step` times the box's widest side. The
// constant changes neither the minimiser nor the relative tolerance. Algorithms without gradients get
// `first_step` of each side by nlopt_set_initial_step.
//
// Rejected points. An objective may refuse a point (`accepted` = false: its value is not to be trusted). The algorithm
// then sees a value above all seen so far that grows with the distance from the best point, with that function's
// gradient, so line searches and trust regions retreat towards the best point. A rejected point is never the result.
//
// Deterministic: no clock; NLopt's stochastic algorithms are seeded. Not reentrant on one thread (NLopt's generator is
// per thread).
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace knap {

struct ObjectiveValue {
  bool accepted = true;            // false: value and gradient are ignored
  double value = 0.0;              // finite when accepted
  std::vector<double> gradient{};  // df/dx, n finite values; may stay empty if the algorithm uses none
};

// f at several points, one answer each in their order: what asks for many at a time lets them be computed side by side.
using Objective = std::function<std::vector<ObjectiveValue>(std::span<const std::vector<double>> points)>;

// Of an f that takes one point.
Objective EachAlone(std::function<ObjectiveValue(const std::vector<double>& x)> f);

struct MinimizerProblem {
  std::vector<double> lower, upper;  // n each, lower_i <= start_i <= upper_i; equal bounds hold a coordinate fixed
  std::vector<double> scale;         // n, > 0, in the units of x: the parameter's range
  std::vector<double> start;
  ObjectiveValue start_value;  // f at the start, known to the caller; accepted
};

struct MinimizerOptions {
  std::string algorithm = "LD_LBFGS";  // NLopt's name without the prefix NLOPT_, or one of evolution_strategy.h
  int max_evaluations = 20;            // of f, the start included; exact; >= 1
  double value_tolerance = 1e-4;       // stop when f changes relatively by less than this [-]; 0: off
  double step_tolerance = 1e-4;        // stop when every |dz_i| is less than this, in units of scale [-]; 0: off
  double first_step = 0.25;            // first step over the box's widest side, in (0, 1] [-]
  std::uint64_t seed = 0;              // for stochastic algorithms
};

enum class MinimizerStop {
  kConverged,    // a tolerance, or a vanishing projected gradient
  kEvaluations,  // max_evaluations reached
  kStalled,      // NLopt's "generic failure" or roundoff: no further progress, an ordinary end
};
const char* GetName(MinimizerStop stop);

struct MinimizerResult {
  std::vector<double> x{};  // the accepted point with the least value, the earliest of equals
  double value = 0.0;
  int evaluations = 0;  // calls of f, the start included
  int rejected = 0;     // of them, not accepted
  MinimizerStop stop = MinimizerStop::kConverged;
};

// Throws std::invalid_argument unless `algorithm` names an evolution strategy, or an NLopt algorithm that, on its own
// and in the NLopt at hand, minimises over a box of any number of coordinates (tried on one and two).
void CheckMinimizerAlgorithm(const std::string& algorithm);

// True when the algorithm asks for gradients (of NLopt's those with a D: LD_, GD_). `algorithm` must have been checked.
bool UsesGradient(const std::string& algorithm);

// f is called with x inside the box, bit-exactly so at the bounds, and never twice for the start. Whatever f throws
// ends the search and comes out of Minimize unchanged. Throws std::invalid_argument for a malformed problem or options,
// and std::runtime_error when NLopt refuses the problem all the same (no memory).
MinimizerResult Minimize(const Objective& f, const MinimizerProblem& problem, const MinimizerOptions& options);

}  // namespace knap
