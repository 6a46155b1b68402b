#include "coordinator/cli/length_argument.h"

#include <fmt/format.h>

#include "coordinator/run/usage_error.h"
#include "sim/scenarios/units.h"

namespace knap {

double ParseLength(std::string_view text, const std::string& option) {
  const auto quantity = ParseQuantity(text);
  const bool is_length = quantity && (quantity->dimension == kLength || quantity->dimension == kDimensionless);
  const double metres = !is_length ? 0.0 : quantity->value * (quantity->dimension == kLength ? 1.0 : 1e-3);
  if (!(metres > 0.0)) {
    throw UsageError(fmt::format("{}: '{}': expected a length of more than 0, in mm or with its unit", option, text));
  }
  return metres;
}

}  // namespace knap
