#include "sim/policy/closed_loop.h"

#include <utility>

#include "sim/math/check.h"

namespace knap {

using Eigen::VectorXd;

ClosedLoop::ClosedLoop(Network network, std::vector<Observation> observations, std::vector<PolicyOutput> outputs,
                       VectorXd weights, int intervals)
    : network_(std::move(network)),
      observations_(std::move(observations)),
      outputs_(std::move(outputs)),
      weights_(std::move(weights)) {
  KNAP_CHECK(static_cast<int>(observations_.size()) == network_.num_inputs() &&
                 static_cast<int>(outputs_.size()) == network_.num_outputs() &&
                 weights_.size() == network_.num_weights(),
             "{} observations, {} outputs and {} weights for a network of {}, {} and {}", observations_.size(),
             outputs_.size(), weights_.size(), network_.num_inputs(), network_.num_outputs(), network_.num_weights());
  commands_.setZero(network_.num_outputs(), intervals);
  inputs_.setZero(network_.num_inputs());
  bar_inputs_ = inputs_;
  bar_outputs_.setZero(network_.num_outputs());
  BeginSweep(commands_);
}

void ClosedLoop::Observe(const FeedbackState& at) {
  for (Eigen::Index i = 0; i < inputs_.size(); ++i) {
    inputs_(i) = CalcObservation(observations_[static_cast<std::size_t>(i)], at);
  }
}

void ClosedLoop::SetControls(const FeedbackState& at, Eigen::Ref<VectorXd> controls) {
  Observe(at);
  commands_.col(at.interval) = network_.Calc(weights_, inputs_);
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
  bar_points_.assign(observations_.size(), Eigen::Vector3d::Zero());
}

void ClosedLoop::PullBack(const FeedbackState& at, Eigen::Ref<VectorXd> bar_controls, FeedbackCotangents* out) {
  Observe(at);
  bar_outputs_ = bar_commands_.col(at.interval);
  for (std::size_t k = 0; k < outputs_.size(); ++k) {
    double& bar_control = bar_controls(outputs_[k].actuator);
    bar_outputs_(static_cast<Eigen::Index>(k)) += outputs_[k].half * bar_control;
    bar_control = 0.0;
  }
  bar_inputs_.setZero();
  network_.PullBack(weights_, inputs_, bar_outputs_, &bar_weights_, &bar_inputs_);
  for (std::size_t i = 0; i < observations_.size(); ++i) {
    PullBackObservation(observations_[i], at, bar_inputs_(static_cast<Eigen::Index>(i)), out, &bar_points_[i]);
  }
}

}  // namespace knap
