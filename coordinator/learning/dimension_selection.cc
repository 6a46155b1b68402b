#include "coordinator/learning/dimension_selection.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace knap {

DimensionSelection::DimensionSelection(std::size_t dimensions, std::size_t dimensions_per_batch, double learning_rate,
                                       double decay)
    : used_(dimensions, false),
      dimensions_per_batch_(dimensions_per_batch),
      learning_rate_(learning_rate),
      decay_(decay) {}

DimensionChoice DimensionSelection::Choose(std::span<const double> normalised_gradient) {
  const std::span<const double> g = normalised_gradient;
  if (g.size() != used_.size()) throw std::invalid_argument("DimensionSelection: the gradient has the wrong length");
  DimensionChoice choice{.learning_rate = learning_rate_};
  std::vector<std::size_t> sloped;  // g_i != 0
  for (std::size_t i = 0; i < g.size(); ++i) {
    if (g[i] != 0.0) sloped.push_back(i);
  }
  if (sloped.empty()) return choice;

  if (std::all_of(sloped.begin(), sloped.end(), [this](std::size_t i) { return used_[i]; })) {
    used_.assign(used_.size(), false);
    learning_rate_ *= decay_;
    ++restarts_;
    choice.restarted = true;
    choice.learning_rate = learning_rate_;
  }
  for (const std::size_t i : sloped) {
    if (!used_[i]) choice.dimensions.push_back(i);
  }
  std::stable_sort(choice.dimensions.begin(), choice.dimensions.end(),
                   [g](std::size_t i, std::size_t j) { return std::abs(g[i]) > std::abs(g[j]); });
  choice.dimensions.resize(std::min(choice.dimensions.size(), dimensions_per_batch_));
  for (const std::size_t i : choice.dimensions) used_[i] = true;
  return choice;
}

}  // namespace knap
