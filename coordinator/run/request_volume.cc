#include "coordinator/run/request_volume.h"

#include <fmt/format.h>

#include "coordinator/run/usage_error.h"

namespace knap {

void CheckRequestVolume(const std::string& what, std::initializer_list<double> counts, std::size_t values_each) {
  constexpr double kMostRollouts = 1e7, kMostValues = 2.5e8;
  double rollouts = 1.0;
  for (const double count : counts) rollouts *= count;
  if (rollouts > kMostRollouts) {
    throw UsageError(
        fmt::format("{}: {:.0f} rollouts at once, at most {:.0f} are allowed", what, rollouts, kMostRollouts));
  }
  if (rollouts * static_cast<double>(values_each) > kMostValues) {
    throw UsageError(fmt::format("{}: {:.0f} rollouts at once with {} numbers each, at most {:.0f} numbers are allowed",
                                 what, rollouts, values_each, kMostValues));
  }
}

}  // namespace knap
