#include "lcmtypes/wire/value_parts.h"

#include <algorithm>

#include "lcmtypes/wire/channels.h"

namespace knap {
namespace {

constexpr std::size_t kPart = kValuesPerPart;

std::size_t CountParts(std::size_t total) { return std::max<std::size_t>(1, (total + kPart - 1) / kPart); }

}  // namespace

void ForEachPart(std::span<const double> values,
                 const std::function<void(std::int32_t first, std::span<const double> part)>& part) {
  for (std::size_t i = 0; i < CountParts(values.size()); ++i) {
    const std::size_t first = i * kPart;
    part(static_cast<std::int32_t>(first), values.subspan(first, std::min(kPart, values.size() - first)));
  }
}

ValueAssembly::ValueAssembly(std::int32_t total)
    : values_(static_cast<std::size_t>(total)), have_(CountParts(values_.size()), false), missing_(have_.size()) {}

bool ValueAssembly::Add(std::int32_t total, std::int32_t first, const std::vector<double>& part) {
  const std::size_t begin = static_cast<std::size_t>(first);
  if (total < 0 || static_cast<std::size_t>(total) != values_.size() || first < 0 || begin % kPart != 0) return false;
  const std::size_t index = begin / kPart;
  if (index >= have_.size() || part.size() != std::min(kPart, values_.size() - begin)) return false;
  if (!have_[index]) {
    std::copy(part.begin(), part.end(), values_.begin() + static_cast<std::ptrdiff_t>(begin));
    have_[index] = true;
    --missing_;
  }
  return true;
}

}  // namespace knap
