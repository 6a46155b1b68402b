// Long vectors of doubles in several messages: how they are cut and how they are put together again.
//
// Every part names the whole length, the index of its first value and its values; parts may come in any order and more
// than once. A vector of length 0 is one empty part. Parts start at multiples of kValuesPerPart.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace knap {

// Calls `part(first, values)` for each part of the vector in ascending order.
void ForEachPart(std::span<const double> values,
                 const std::function<void(std::int32_t first, std::span<const double> part)>& part);

class ValueAssembly {
 public:
  // total: length of the whole vector, within [0, kMaxValues]
  explicit ValueAssembly(std::int32_t total);

  // Adds one part; false when it cannot belong to this vector (it is then ignored).
  bool Add(std::int32_t total, std::int32_t first, const std::vector<double>& part);

  bool IsComplete() const { return missing_ == 0; }
  const std::vector<double>& values() const { return values_; }

 private:
  std::vector<double> values_;
  std::vector<bool> have_;  // one flag for each part
  std::size_t missing_;
};

}  // namespace knap
