// Rules that several checks of a scene use.
#pragma once

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

namespace knap {

// Rounding in numbers that a person wrote in decimal.
inline constexpr double kDecimalRoundOff = 1e-9;

inline bool IsWholeMultiple(double x, double unit) {
  const double ratio = x / unit;
  return std::abs(ratio - std::round(ratio)) <= kDecimalRoundOff * std::max(1.0, std::abs(ratio)) &&
         std::round(ratio) >= 1.0;
}

template <class T>
bool HasRepeats(const std::vector<T>& items) {
  return std::set<T>(items.begin(), items.end()).size() != items.size();
}

}  // namespace knap
