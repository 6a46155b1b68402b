// Do rollout gradients agree with central differences of rollout losses? Asked of any simulator behind RolloutService.
//
// Pairs (variation, theta) are drawn in order, theta uniformly within the bounds less the largest difference step,
// until enough of them have a task gradient that is not zero. Zero gradients (the tool never touched, or the goal was
// met) say nothing about accuracy: they are counted and left out. A rollout then agrees when for every parameter
//
//   |g_i − fd_i| ≤ tolerance·‖g‖∞     on a plateau of at least three consecutive difference steps,
//
// g and fd in range-normalised parameters, g_i = dL/dtheta_i·(upper_i − lower_i); see difference_ladder.h. Where time
// steps are chosen, they would be chosen anew at every theta and the loss would jump: the rollouts that are subtracted
// take the steps chosen at the theta in question, moved along with touchdowns (RolloutQuery::theta_nodes): of these the
// gradient is the derivative. That it is the problem's too is asked elsewhere (docs/method.md).
//
// What learning leaves fixed (ParameterSpec::fixed), such as the weights of a policy that is given, stays at its
// initial value and is not compared: drawn weights would make another policy, and there are hundreds of them.
//
// One that does not agree is flagged when its certificate itself warns: not finite, not converged, or its gradient not
// reliable. What neither agrees nor is flagged is what the check exists to find. How many of all certificates warn is
// counted besides: most of what they warn of, time steps and cascades of touchdowns, is no matter of differences.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "coordinator/gradcheck/difference_ladder.h"
#include "coordinator/learning/problem.h"
#include "coordinator/rollout_service.h"

namespace knap {

struct GradientCheckOptions {
  int rollouts = 100;       // to be checked; ≥ 1
  std::uint64_t seed = 0;   // variations: kTrainingVariations, thetas: kRandomThetas
  double tolerance = 1e-5;  // relative to ‖g‖∞; > 0
  double flagged = 0.05;    // share of rollouts that may be flagged
};

// Rollouts that one round asks for a parameter of a rollout that is compared, at most.
inline constexpr int kQueriesPerParameter = 2 * kWindow;

// At most this many draws for each rollout to be checked.
inline constexpr int kDrawsPerRollout = 20;

struct ParameterCheck {
  double analytic = 0.0;        // dL/dtheta_i, SI
  double difference = 0.0;      // central difference in the middle of the best window, SI; NaN: could not be had
  double step = 0.0;            // there, as a fraction of the range
  double relative_error = 0.0;  // |g_i − fd_i|/‖g‖∞, the largest in the best window; infinity: could not be had
  int plateau_steps = 0;        // consecutive steps that agree, at least three where the parameter agrees; else 0
  bool fixed = false;           // not compared
};

enum class GradientVerdict { kAgreed, kFlagged, kDisagreed };

struct CheckedRollout {
  std::int64_t draw = 0;  // from 0
  std::vector<double> theta;
  std::vector<double> variation;
  RolloutOutcome outcome;                  // with the analytic gradient
  std::vector<ParameterCheck> parameters;  // d; empty when the rollout has no gradient to compare
  GradientVerdict verdict = GradientVerdict::kDisagreed;
  double relative_error = 0.0;  // the largest of its parameters; infinity without any
};

struct GradientCheckReport {
  std::vector<CheckedRollout> rollouts;  // in the order drawn
  int agreed = 0, flagged = 0, disagreed = 0;
  int doubted = 0;             // whose certificates warn, whether they agree or not
  int nonconverged = 0;        // of the flagged: not finite or not converged, so without a gradient to compare
  int zero_gradient = 0;       // draws left out
  std::int64_t draws = 0;      // up to the last one needed
  std::int64_t evaluated = 0;  // rollouts run in all, differences included
  double max_rel_error = 0.0;  // of the rollouts that agreed

  int checked() const { return static_cast<int>(rollouts.size()); }
};

// At the start of a round.
struct GradientCheckProgress {
  int drawn = 0;           // rollouts with a gradient so far
  int settled = 0;         // of these: compared
  std::int64_t asked = 0;  // rollouts asked for, this round included
};

// Follows a check. Either may be empty.
struct GradientCheckObserver {
  std::function<void(const GradientCheckProgress&)> on_round;
  std::function<void(const CheckedRollout&)> on_verdict;  // once a rollout, as soon as it is settled
};

// A pure function of its first two arguments and the service's answers. Throws what the service throws, and
// std::invalid_argument when an option is out of range or the problem is not valid (CheckProblem).
GradientCheckReport CheckGradients(const Problem& problem, const GradientCheckOptions& options, RolloutService& service,
                                   const GradientCheckObserver& observer);

// Rollouts that the check asks for when no gradient is zero and the first steps of every parameter agree.
std::int64_t CalcLeastRollouts(const Problem& problem, const GradientCheckOptions& options);

// Why the check has not passed, one line each; none when it has: enough rollouts were found, no more than the allowed
// share are flagged and every other one agrees.
std::vector<std::string> ListFailures(const GradientCheckReport& report, const GradientCheckOptions& options);

}  // namespace knap
