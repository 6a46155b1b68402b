#include "coordinator/run/loss_unit.h"

#include <fmt/format.h>

#include <optional>
#include <set>
#include <string>
#include <utility>

#include "sim/scenarios/signal_fields.h"
#include "sim/scenarios/units.h"

namespace knap {
namespace {

std::string GetScaleName(double scale, const Dimension& dimension) {
  constexpr std::pair<double, const char*> kLengths[] = {
      {1.0, "m"}, {0.01, "cm"}, {0.001, "mm"}, {1e-6, "um"}, {1000.0, "km"}};
  for (const auto& [length, name] : kLengths) {
    if (dimension == kLength && scale == length) return name;
  }
  return scale == 1.0 ? UnitName(dimension) : fmt::format("({})", FormatQuantity(scale, dimension));
}

}  // namespace

std::string FormatLossUnit(const Scene& scene) {
  Scene copy = scene;  // visitors take no const one
  const SignalDimensions dimensions(copy);
  std::set<std::string> units;
  std::set<int> powers;  // of the unit; 0: another kind of term
  bool are_lengths = true;
  for (const Term& term : scene.loss.task) {
    const std::optional<Dimension> dimension = dimensions.Find(term.signals.front());
    const bool is_power = term.shape == TermShape::kSquare || term.shape == TermShape::kAbsolute;
    if (!is_power || !dimension || *dimension == kDimensionless) {
      powers.insert(0);
      continue;
    }
    are_lengths = are_lengths && *dimension == kLength;
    units.insert(GetScaleName(term.scale, *dimension));
    powers.insert(term.shape == TermShape::kSquare ? 2 : 1);
  }
  if (units.size() != 1) return {};
  const std::string& name = *units.begin();
  if (powers.size() > 1) return fmt::format(" ({} in {})", are_lengths ? "lengths" : "counted", name);
  return fmt::format(" {}{}", name, *powers.begin() == 2 ? "²" : "");
}

}  // namespace knap
