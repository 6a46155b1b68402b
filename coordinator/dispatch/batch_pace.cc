#include "coordinator/dispatch/batch_pace.h"

#include <algorithm>
#include <vector>

#include "lcmtypes/wire/channels.h"

namespace knap {
namespace {

constexpr std::size_t kRemembered = 256;
constexpr std::int64_t kLeastDelayUs = 20'000;
constexpr std::int64_t kHeldUs = 20'000;

}  // namespace

void BatchPace::Record(std::int64_t duration_us) {
  durations_us_.push_back(duration_us);
  if (durations_us_.size() > kRemembered) durations_us_.pop_front();
}

std::int64_t BatchPace::CalcMedianUs() const {
  if (durations_us_.empty()) return -1;
  std::vector<std::int64_t> sorted(durations_us_.begin(), durations_us_.end());
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  return *middle;
}

bool BatchPace::IsStraggling(std::int64_t age_us, std::size_t open) const {
  if (4 * open > requests_ || age_us <= kLeastDelayUs) return false;
  const std::int64_t median_us = CalcMedianUs();
  return median_us >= 0 && 2 * (age_us - kLeastDelayUs) > 3 * median_us;
}

int BatchPace::CalcCredits(int least) const {
  const std::int64_t median_us = CalcMedianUs();
  if (median_us < 0) return least;
  const std::int64_t wanted = kHeldUs / std::max<std::int64_t>(median_us, 1);
  return static_cast<int>(std::clamp<std::int64_t>(wanted, least, kMaxQueue));
}

}  // namespace knap
