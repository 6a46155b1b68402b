// Writes what a variation draws into a scene, and refuses what the scene does not allow, as its file's own numbers are
// refused.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sim/scenarios/numeric_keys.h"
#include "sim/scenarios/scene.h"

namespace knap {

// Why drawn numbers are refused.
struct DrawRefusal {
  std::vector<std::size_t> variations;  // the numbers concerned, as VariedNumbers counts them; at least one
  // "bodies.box.shapes[0].size[0] = 0.001 m: bodies.box.shapes[0].rounding must be at most half …"
  std::string message;
};

// The varied numbers of one scene.
class VariedNumbers {
 public:
  // `scene` must outlive this object, and its lists and variants stay as they are. Throws std::invalid_argument naming
  // a key that the scene does not have; a scene from ParseScene has all that its variation names.
  explicit VariedNumbers(Scene& scene);

  std::size_t size() const { return keys_.size(); }
  double Get(std::size_t i) const { return *keys_[i].value; }
  void Set(std::size_t i, double value) { *keys_[i].value = value; }

  // Of the numbers as they are now: the first that is not finite, out of its field's range, or does not fit others
  // (check_values.h). The scene as its file has it was valid.
  std::optional<DrawRefusal> FindRefusal() const;

 private:
  bool IsWithin(std::size_t i, const std::string& path) const;
  std::string Describe(std::size_t i) const;

  const Scene& scene_;
  std::vector<NumericKey> keys_;  // ListVariedKeys
};

// Sets the varied numbers to `values`, in the order of ListVariedKeys, in SI. Throws std::invalid_argument with one
// line when the sizes differ or a value is refused.
void ApplyVariation(Scene& scene, std::span<const double> values);

}  // namespace knap
