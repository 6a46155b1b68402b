#include "sim/scenarios/field_visitor.h"

#include <fmt/format.h>

#include <cmath>

namespace knap {

std::string DescribeRange(const Range& range, const Dimension& dimension) {
  const bool has_lower = std::isfinite(range.lower);
  const bool has_upper = std::isfinite(range.upper);
  const std::string lower = has_lower ? FormatQuantity(range.lower, dimension) : "";
  const std::string upper = has_upper ? FormatQuantity(range.upper, dimension) : "";
  if (has_lower && has_upper && range.lower == range.upper) return lower;
  if (has_lower && has_upper && range.above) return fmt::format("more than {} and at most {}", lower, upper);
  if (has_lower && has_upper) return fmt::format("from {} to {}", lower, upper);
  if (has_lower) return fmt::format("{} {}", range.above ? "more than" : "at least", lower);
  if (has_upper) return fmt::format("at most {}", upper);
  return {};
}

}  // namespace knap
