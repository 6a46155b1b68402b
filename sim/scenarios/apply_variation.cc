#include "sim/scenarios/apply_variation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <utility>

#include "sim/scenarios/check_values.h"
#include "sim/scenarios/units.h"

namespace knap {

VariedNumbers::VariedNumbers(Scene& scene) : scene_(scene) {
  const std::vector<NumericKey> all = ListNumericKeys(scene);
  for (const std::string& key : ListVariedKeys(scene.variation)) {
    const auto found = std::find_if(all.begin(), all.end(), [&](const NumericKey& k) { return k.path == key; });
    if (found == all.end()) throw std::invalid_argument(fmt::format("the scene has no number '{}'", key));
    keys_.push_back(*found);
  }
}

// Whether number i is the one at `path` or lies in the list or section there.
bool VariedNumbers::IsWithin(std::size_t i, const std::string& path) const {
  const std::string& key = keys_[i].path;
  return key.starts_with(path) && (key.size() == path.size() || key[path.size()] == '.' || key[path.size()] == '[');
}

std::string VariedNumbers::Describe(std::size_t i) const {
  return fmt::format("{} = {}", keys_[i].path, FormatQuantity(Get(i), keys_[i].dimension));
}

std::optional<DrawRefusal> VariedNumbers::FindRefusal() const {
  for (std::size_t i = 0; i < keys_.size(); ++i) {
    if (std::isfinite(Get(i)) && keys_[i].range.Contains(Get(i))) continue;
    const std::string allowed = DescribeRange(keys_[i].range, keys_[i].dimension);
    return DrawRefusal{{i}, fmt::format("{}: must be {}", Describe(i), allowed.empty() ? "finite" : allowed)};
  }
  const std::vector<ValueFault> faults = FindValueFaults(scene_);
  if (faults.empty()) return std::nullopt;
  const ValueFault& fault = faults.front();
  DrawRefusal refusal;
  for (std::size_t i = 0; i < keys_.size(); ++i) {
    const bool concerned =
        std::any_of(fault.paths.begin(), fault.paths.end(), [&](const std::string& path) { return IsWithin(i, path); });
    if (concerned) refusal.variations.push_back(i);
  }
  // A fault that names none of the varied numbers is the file's own; whoever asks should still learn of it.
  if (refusal.variations.empty()) {
    refusal.variations.resize(keys_.size());
    std::iota(refusal.variations.begin(), refusal.variations.end(), 0);
  }
  for (const std::size_t i : refusal.variations) {
    refusal.message += (refusal.message.empty() ? "" : ", ") + Describe(i);
  }
  const bool names_itself =
      refusal.variations.size() == 1 && keys_[refusal.variations.front()].path == fault.paths.front();
  refusal.message += ": " + (names_itself ? "" : fault.paths.front() + ": ") + fault.message;
  return refusal;
}

void ApplyVariation(Scene& scene, std::span<const double> values) {
  VariedNumbers numbers(scene);
  if (values.size() != numbers.size()) {
    throw std::invalid_argument(
        fmt::format("{} variation values for a scene that varies {} numbers", values.size(), numbers.size()));
  }
  for (std::size_t i = 0; i < values.size(); ++i) numbers.Set(i, values[i]);
  if (const std::optional<DrawRefusal> refusal = numbers.FindRefusal()) {
    throw std::invalid_argument("the variation is not allowed: " + refusal->message);
  }
}

}  // namespace knap
