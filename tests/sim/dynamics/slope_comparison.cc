#include "tests/sim/dynamics/slope_comparison.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "coordinator/gradcheck/difference_ladder.h"

namespace knap::test {
namespace {

// The orders of the remainder to one side.
struct RemainderOrders {
  std::string text;
  bool confirmed = false;
};

RemainderOrders CalcRemainderOrders(double slope, const LossAlong& loss, double unit) {
  constexpr int kRow = 3;
  RemainderOrders out;
  const double start = loss(0.0);
  double previous = 0.0;
  int row = 0;
  for (int k = 6; k <= 20 && !out.confirmed; ++k) {
    const double h = std::ldexp(unit, -k);
    const double remainder = std::abs(loss(h) - start - h * slope);
    if (k > 6) {
      const double order = std::log2(previous / remainder);
      out.text += fmt::format(" {:.2f}", order);
      row = std::abs(order - 2.0) <= 0.1 ? row + 1 : 0;
      out.confirmed = row == kRow;
    }
    previous = remainder;
  }
  return out;
}

}  // namespace

void SlopeComparison::Add(std::string kind, double slope, LossAlong loss, double unit) {
  slopes_.push_back({std::move(kind), slope, std::move(loss), unit});
}

std::string SlopeComparison::Compare(double tolerance, std::map<std::string, int>* compared) const {
  double largest = 0.0;
  for (const Slope& s : slopes_) largest = std::max(largest, std::abs(s.slope));
  if (!(largest > 0.0)) return "all slopes are zero";
  for (const Slope& s : slopes_) {
    DifferenceLadder ladder;
    DifferenceLadder::Window window;
    for (std::vector<int> next = ladder.ListNextSteps(); !next.empty() && window.plateau_steps < kWindow;
         next = ladder.ListNextSteps()) {
      for (const int k : next) {
        const double h = s.unit * CalcLadderStep(k);
        ladder.Set(k, (s.loss(h) - s.loss(-h)) / (2.0 * h));
      }
      window = ladder.FindBestWindow(s.slope, tolerance * largest);
    }
    if (window.plateau_steps < kWindow) {
      return fmt::format("{}: slope {:g}, differences {:g}, an error of {:.2g} of the largest slope, {:g}", s.kind,
                         s.slope, window.difference, window.error / largest, largest);
    }
    if (compared != nullptr && std::abs(s.slope) >= kLeastShare * largest) ++(*compared)[s.kind];
  }
  return "";
}

std::string CheckTaylorRemainder(double slope, const LossAlong& loss, double unit) {
  const RemainderOrders ahead = CalcRemainderOrders(slope, loss, unit);
  if (ahead.confirmed) return "";
  const RemainderOrders behind = CalcRemainderOrders(slope, loss, -unit);
  if (behind.confirmed) return "";
  return fmt::format("orders of the remainder ahead:{}, behind:{}", ahead.text, behind.text);
}

}  // namespace knap::test
