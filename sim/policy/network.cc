#include "sim/policy/network.h"

#include <algorithm>
#include <cmath>

#include "sim/math/check.h"

namespace knap {

using Eigen::VectorXd;

Network::Network(int inputs, const std::vector<int>& hidden, int outputs, bool squashed) : squashed_(squashed) {
  sizes_.push_back(inputs);
  sizes_.insert(sizes_.end(), hidden.begin(), hidden.end());
  sizes_.push_back(outputs);
  KNAP_CHECK(*std::min_element(sizes_.begin(), sizes_.end()) >= 1, "a network with a layer of {} units",
             *std::min_element(sizes_.begin(), sizes_.end()));
  for (const int size : sizes_) values_.push_back(VectorXd::Zero(size));
  bars_ = values_;
  for (int l = 0; l < CountLayers(); ++l) num_weights_ += sizes_[l + 1] * (sizes_[l] + 1);
}

std::vector<int> Network::ListFanIns() const {
  std::vector<int> fan_ins;
  for (int l = 0; l < CountLayers(); ++l) {
    fan_ins.insert(fan_ins.end(), static_cast<std::size_t>(sizes_[l]) * sizes_[l + 1], sizes_[l]);
    fan_ins.insert(fan_ins.end(), sizes_[l + 1], 0);
  }
  return fan_ins;
}

const VectorXd& Network::Calc(const VectorXd& weights, const VectorXd& inputs) {
  KNAP_CHECK(weights.size() == num_weights_ && inputs.size() == num_inputs(),
             "{} weights and {} inputs for a network of {} and {}", weights.size(), inputs.size(), num_weights_,
             num_inputs());
  values_[0] = inputs;
  const double* w = weights.data();
  for (int l = 0; l < CountLayers(); ++l) {
    const int n = sizes_[l];
    const int m = sizes_[l + 1];
    const double* biases = w + n * m;
    for (int i = 0; i < m; ++i) {
      double sum = biases[i];
      for (int j = 0; j < n; ++j) sum += w[i * n + j] * values_[l](j);
      values_[l + 1](i) = IsSquashed(l) ? std::tanh(sum) : sum;
    }
    w = biases + m;
  }
  return values_.back();
}

void Network::PullBack(const VectorXd& weights, const VectorXd& inputs, const VectorXd& bar_outputs,
                       VectorXd* bar_weights, VectorXd* bar_inputs) {
  KNAP_CHECK(
      bar_outputs.size() == num_outputs() && bar_weights->size() == num_weights_ && bar_inputs->size() == num_inputs(),
      "cotangents of {} outputs, {} weights and {} inputs for a network of {}, {} and {}", bar_outputs.size(),
      bar_weights->size(), bar_inputs->size(), num_outputs(), num_weights_, num_inputs());
  Calc(weights, inputs);
  bars_.back() = bar_outputs;
  int end = num_weights_;
  for (int l = CountLayers() - 1; l >= 0; --l) {
    const int n = sizes_[l];
    const int m = sizes_[l + 1];
    const int begin = end - m * (n + 1);
    bars_[l].setZero();
    for (int i = 0; i < m; ++i) {
      const double y = values_[l + 1](i);
      const double bar_a = bars_[l + 1](i) * (IsSquashed(l) ? 1.0 - y * y : 1.0);
      for (int j = 0; j < n; ++j) {
        (*bar_weights)(begin + i * n + j) += bar_a * values_[l](j);
        bars_[l](j) += bar_a * weights(begin + i * n + j);
      }
      (*bar_weights)(begin + n * m + i) += bar_a;
    }
    end = begin;
  }
  *bar_inputs += bars_.front();
}

}  // namespace knap
