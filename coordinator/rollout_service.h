// The seam between the schedule and the cluster: bounded vectors and variations go in, losses and gradients come out.
//
// The schedule, the optimizer and the evaluation see only this interface; the dispatcher implements it over LCM, and
// tests implement it with closed forms. Nothing here knows what is simulated.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <vector>

namespace knap {

// What is asked of one rollout. All numbers are SI. Two queries with the same bits have the same answer.
struct RolloutQuery {
  std::vector<double> theta;            // the d values that are decided on: design, then controls or weights
  std::vector<double> theta_reference;  // empty: task loss; d values: distillation loss against the trajectory at these
  std::vector<double> variation;        // one value for each varied key of the scenario
  bool gradient = true;                 // false: loss and success alone, the answer's gradient stays empty
  // Empty: time steps are chosen. d values, without gradient: the steps chosen at these are taken, moved along with
  // what happens (docs/method.md, gradient checks); a simulator that chooses no steps may ignore it.
  std::vector<double> theta_nodes{};
};

// What the simulator says about the trust its own answer deserves [docs/method.md].
struct RolloutCertificate {
  bool finite = false;             // every number of the answer is finite
  bool converged = false;          // every step met its Newton tolerance
  bool gradient_reliable = false;  // nothing tells that the gradient is not that of the problem (docs/method.md)
  double worst_residual = 0.0;     // largest scaled Newton residual accepted [-]
  std::int32_t subdivided_steps = 0;
  std::int32_t contact_onsets = 0;
  double penetration = 0.0;    // the deepest contact, as a share of what the thinner body has
  double largest_force = 0.0;  // of one contact [N]
  std::string distrust{};      // why the rollout is not to be trusted; empty: nothing tells against it
  double loss_error = std::numeric_limits<double>::quiet_NaN();  // of time steps, Newton, rounding; NaN: not known
};

struct RolloutOutcome {
  double loss = 0.0;
  bool success = false;
  std::vector<double> gradient;  // d values: dloss/dtheta, or empty
  RolloutCertificate certificate{};
  std::int32_t steps = 0;
  double forward_s = 0.0;   // wall time, for reports alone
  double gradient_s = 0.0;  // wall time, for reports alone
};

class RolloutService {
 public:
  virtual ~RolloutService() = default;

  // Answers queries[i] in outcome[i], whatever the order in which answers arrive. Throws std::runtime_error with one
  // clear line when the answer cannot be had (no workers, a poison request, an interrupted run).
  virtual std::vector<RolloutOutcome> Evaluate(std::span<const RolloutQuery> queries) = 0;
};

}  // namespace knap
