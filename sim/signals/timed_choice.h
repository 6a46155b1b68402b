// Which entry of a schedule counts.
#pragma once

#include <vector>

namespace knap {

// The last of `items`, ascending in `after`, whose time has passed, or the first one. A sample at the very time of a
// change, but for rounding, still belongs to what was before.
template <class Timed>
const Timed& ChooseAfter(const std::vector<Timed>& items, double time) {
  constexpr double kRounding = 1e-9;  // [s]
  std::size_t chosen = 0;
  while (chosen + 1 < items.size() && time > items[chosen + 1].after + kRounding) ++chosen;
  return items[chosen];
}

}  // namespace knap
