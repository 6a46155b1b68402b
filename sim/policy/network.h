// A small feed-forward network, as a function of its inputs and of one flat vector of weights, with its exact
// pull-back.
//
//   h_0 = x,   h_l = tanh(W_l h_{l−1} + b_l)  for the hidden layers,   y = s(W_L h_{L−1} + b_L),   s = tanh or identity
//
//   bar_a_l = s'(a_l) ∘ bar_h_l,   bar_W_l = bar_a_l h_{l−1}ᵀ,   bar_b_l = bar_a_l,   bar_h_{l−1} = W_lᵀ bar_a_l
//
// with a_l the argument of the activation and tanh' = 1 − tanh². The weights of a layer are W_l row by row, then b_l;
// the layers follow one another. Sums run in the order of the inputs, so their bits do not hang on how vectors are
// aligned or instructions chosen.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace knap {

class Network {
 public:
  // Numbers of inputs, of each hidden layer's units, of outputs; each at least 1.
  Network(int inputs, const std::vector<int>& hidden, int outputs, bool squashed);

  int num_inputs() const { return sizes_.front(); }
  int num_outputs() const { return sizes_.back(); }
  int num_weights() const { return num_weights_; }

  // For each weight how many inputs its unit has; 0 where it is a bias: what random initial weights are scaled by.
  std::vector<int> ListFanIns() const;

  // y of num_outputs() values, valid until the next call. No allocation.
  const Eigen::VectorXd& Calc(const Eigen::VectorXd& weights, const Eigen::VectorXd& inputs);

  // Adds to *bar_weights and to *bar_inputs what `bar_outputs` puts on them at these weights and inputs.
  void PullBack(const Eigen::VectorXd& weights, const Eigen::VectorXd& inputs, const Eigen::VectorXd& bar_outputs,
                Eigen::VectorXd* bar_weights, Eigen::VectorXd* bar_inputs);

 private:
  int CountLayers() const { return static_cast<int>(sizes_.size()) - 1; }
  bool IsSquashed(int layer) const { return layer + 1 < CountLayers() || squashed_; }

  std::vector<int> sizes_;  // inputs, hidden…, outputs
  bool squashed_;
  int num_weights_ = 0;
  std::vector<Eigen::VectorXd> values_;  // h_0 … h_L of the last Calc
  std::vector<Eigen::VectorXd> bars_;    // their cotangents
};

}  // namespace knap
