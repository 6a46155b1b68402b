// A network between signals and actuators: the closed-loop policy of one rollout.
//
//   y_i = network(weights, (signal − offset)/scale at the start of interval i)          commands, one an output
//   control of the actuator of output k:  center_k + half_k y_i[k]
//
// Cotangents come from the adjoint's sweep, and from losses that see the commands themselves (bar_commands).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "sim/integrators/feedback.h"
#include "sim/policy/network.h"
#include "sim/signals/signal_function.h"

namespace knap {

// What an input of the network sees; the signal needs no track.
struct PolicyInput {
  SignalPointer signal;
  double offset = 0.0;
  double scale = 1.0;  // > 0
};

// Where an output of the network goes.
struct PolicyOutput {
  int actuator = 0;  // of the tree
  double center = 0.0;
  double half = 1.0;
};

class ClosedLoop final : public Feedback {
 public:
  // As many inputs and outputs as the network has, and its weights. `num_points`: watched points, of all signals.
  ClosedLoop(Network network, std::vector<PolicyInput> inputs, std::vector<PolicyOutput> outputs,
             Eigen::VectorXd weights, int intervals, int num_points);

  void SetControls(const FeedbackState& at, Eigen::Ref<Eigen::VectorXd> controls) override;
  void PullBack(const FeedbackState& at, Eigen::Ref<Eigen::VectorXd> bar_controls,
                std::vector<StateCotangent>* out) override;

  // Of the rollout so far: a row an output, a column an interval.
  const Eigen::MatrixXd& commands() const { return commands_; }

  // Before a sweep: the losses' own cotangents of the commands, of the same shape. Forgets an earlier sweep.
  void BeginSweep(const Eigen::MatrixXd& bar_commands);
  // After it.
  const Eigen::VectorXd& bar_weights() const { return bar_weights_; }
  const std::vector<Eigen::Vector3d>& bar_points() const { return bar_signals_.points; }  // of each watched point, in B

 private:
  void Observe(const FeedbackState& at);

  Network network_;
  std::vector<PolicyInput> inputs_;
  std::vector<PolicyOutput> outputs_;
  Eigen::VectorXd weights_;
  Eigen::MatrixXd commands_;
  Eigen::MatrixXd bar_commands_;
  Eigen::VectorXd bar_weights_;
  SignalCotangents bar_signals_;
  Eigen::VectorXd seen_, bar_seen_, bar_outputs_;  // scratch
};

}  // namespace knap
