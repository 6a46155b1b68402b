#include "coordinator/gradcheck/difference_ladder.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace knap {
namespace {

// The first window: 2^(−19), 2^(−20), 2^(−21).
constexpr int kFirstMiddle = kLadderSteps / 2;

double CalcError(double difference, double derivative) {
  const double error = std::abs(difference - derivative);
  return std::isnan(error) ? std::numeric_limits<double>::infinity() : error;
}

}  // namespace

double CalcLadderStep(int k) { return std::ldexp(1.0, -10 - k); }

double CalcLargestStep() { return CalcLadderStep(0); }

std::vector<int> DifferenceLadder::ListNextSteps() const {
  if (last_ < first_) return {kFirstMiddle - 1, kFirstMiddle, kFirstMiddle + 1};
  std::vector<int> next;
  if (first_ > 0) next.push_back(first_ - 1);
  if (last_ + 1 < kLadderSteps) next.push_back(last_ + 1);
  return next;
}

void DifferenceLadder::Set(int k, double difference) {
  differences_[static_cast<std::size_t>(k)] = difference;
  first_ = last_ < first_ ? k : std::min(first_, k);
  last_ = std::max(last_, k);
}

template <class Difference>
DifferenceLadder::Window DifferenceLadder::FindBest(const Difference& difference, int first, int last,
                                                    double derivative, double tolerance) {
  const auto error = [&](int k) { return CalcError(difference(k), derivative); };
  Window best{.error = std::numeric_limits<double>::infinity()};
  for (int middle = first + 1; middle < last; ++middle) {
    const double worst = std::max({error(middle - 1), error(middle), error(middle + 1)});
    if (middle > first + 1 && !(worst < best.error)) continue;
    best = {.middle = middle, .error = worst, .difference = difference(middle)};
  }
  if (best.error <= tolerance) {
    int low = best.middle, high = best.middle;
    while (low > first && error(low - 1) <= tolerance) --low;
    while (high < last && error(high + 1) <= tolerance) ++high;
    best.plateau_steps = high - low + 1;
  }
  return best;
}

DifferenceLadder::Window DifferenceLadder::FindBestWindow(double derivative, double tolerance) const {
  const auto at = [this](int k) { return differences_[static_cast<std::size_t>(k)]; };
  const Window plain = FindBest(at, first_, last_, derivative, tolerance);
  if (plain.plateau_steps > 0) return plain;
  const auto fourth_order = [&](int k) { return (4.0 * at(k) - at(k - 1)) / 3.0; };
  const Window extrapolated = FindBest(fourth_order, first_ + 1, last_, derivative, tolerance);
  return extrapolated.plateau_steps > 0 ? extrapolated : plain;
}

}  // namespace knap
