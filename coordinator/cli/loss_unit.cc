#include "coordinator/cli/loss_unit.h"

#include <fmt/format.h>

#include <set>
#include <utility>
#include <variant>

#include "sim/math/overloaded.h"
#include "sim/scenarios/units.h"

namespace knap {
namespace {

std::string GetLengthName(double unit) {
  constexpr std::pair<double, const char*> kNames[] = {
      {1.0, "m"}, {0.01, "cm"}, {0.001, "mm"}, {1e-6, "um"}, {1000.0, "km"}};
  for (const auto& [length, name] : kNames) {
    if (unit == length) return name;
  }
  return fmt::format("({})", FormatQuantity(unit, kLength));
}

}  // namespace

std::string FormatLossUnit(const Scene& scene) {
  std::set<double> units;
  std::set<int> powers;  // of a length; 0: another kind of term
  const auto add = [&](double unit, int power) {
    units.insert(unit);
    powers.insert(power);
  };
  for (const TaskTerm& term : scene.loss.task) {
    std::visit(Overloaded{[&](const CrossingLoss& t) { add(t.length_unit, 2); },
                          [&](const HeightHoldLoss& t) { add(t.height.length_unit, 2); },
                          [&](const PointTargetLoss& t) { add(t.length_unit, 1); },
                          [&](const ControlCostLoss&) { powers.insert(0); }},
               term);
  }
  if (units.size() != 1) return {};
  const std::string name = GetLengthName(*units.begin());
  if (powers.size() > 1) return fmt::format(" (lengths in {})", name);
  return fmt::format(" {}{}", name, *powers.begin() == 2 ? "²" : "");
}

}  // namespace knap
