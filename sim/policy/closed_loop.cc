#include "sim/policy/closed_loop.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "sim/math/check.h"

namespace knap {

using Eigen::VectorXd;

ClosedLoop::ClosedLoop(Network network, std::vector<PolicyInput> inputs, std::vector<PolicyOutput> outputs,
                       VectorXd weights, int intervals, int num_points)
    : network_(std::move(network)),
      inputs_(std::move(inputs)),
      outputs_(std::move(outputs)),
      weights_(std::move(weights)) {
  KNAP_CHECK(static_cast<int>(inputs_.size()) == network_.num_inputs() &&
                 static_cast<int>(outputs_.size()) == network_.num_outputs() &&
                 weights_.size() == network_.num_weights(),
             "{} inputs, {} outputs and {} weights for a network of {}, {} and {}", inputs_.size(), outputs_.size(),
             weights_.size(), network_.num_inputs(), network_.num_outputs(), network_.num_weights());
  commands_.setZero(network_.num_outputs(), intervals);
  seen_.setZero(network_.num_inputs());
  bar_seen_ = seen_;
  bar_signals_.points.resize(static_cast<std::size_t>(num_points));
  bar_outputs_.setZero(network_.num_outputs());
  BeginSweep(commands_);
}

static Moment MakeMoment(const FeedbackState& at) { return {at.state, at.time, at.q, at.v, at.kinematics}; }

void ClosedLoop::Observe(const FeedbackState& at) {
  const Moment moment = MakeMoment(at);
  for (std::size_t i = 0; i < inputs_.size(); ++i) {
    seen_(static_cast<Eigen::Index>(i)) = (inputs_[i].signal->Calc(moment) - inputs_[i].offset) / inputs_[i].scale;
  }
}

void ClosedLoop::SetControls(const FeedbackState& at, Eigen::Ref<VectorXd> controls) {
  Observe(at);
  commands_.col(at.interval) = network_.Calc(weights_, seen_);
  for (std::size_t k = 0; k < outputs_.size(); ++k) {
    const PolicyOutput& output = outputs_[k];
    controls(output.actuator) = output.center + output.half * commands_(static_cast<Eigen::Index>(k), at.interval);
  }
}

void ClosedLoop::BeginSweep(const Eigen::MatrixXd& bar_commands) {
  KNAP_CHECK(bar_commands.rows() == commands_.rows() && bar_commands.cols() == commands_.cols(),
             "cotangents of {} x {} commands, not {} x {}", bar_commands.rows(), bar_commands.cols(), commands_.rows(),
             commands_.cols());
  bar_commands_ = bar_commands;
  bar_weights_.setZero(weights_.size());
  std::fill(bar_signals_.points.begin(), bar_signals_.points.end(), Eigen::Vector3d::Zero());
}

void ClosedLoop::PullBack(const FeedbackState& at, Eigen::Ref<VectorXd> bar_controls,
                          std::vector<StateCotangent>* out) {
  Observe(at);
  bar_outputs_ = bar_commands_.col(at.interval);
  for (std::size_t k = 0; k < outputs_.size(); ++k) {
    double& bar_control = bar_controls(outputs_[k].actuator);
    bar_outputs_(static_cast<Eigen::Index>(k)) += outputs_[k].half * bar_control;
    bar_control = 0.0;
  }
  bar_seen_.setZero();
  network_.PullBack(weights_, seen_, bar_outputs_, &bar_weights_, &bar_seen_);
  bar_signals_.states.clear();
  const Moment moment = MakeMoment(at);
  for (std::size_t i = 0; i < inputs_.size(); ++i) {
    inputs_[i].signal->PullBack(moment, bar_seen_(static_cast<Eigen::Index>(i)) / inputs_[i].scale, &bar_signals_);
  }
  out->insert(out->end(), bar_signals_.states.begin(), bar_signals_.states.end());
}

}  // namespace knap
