#include "coordinator/run/loss_unit.h"

#include <fmt/format.h>

#include <numbers>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "sim/scenarios/signal_fields.h"
#include "sim/scenarios/units.h"

namespace knap {
namespace {

// Units in which people give lengths and angles, before the SI's.
struct CommonUnit {
  Dimension dimension;
  double value;
  const char* name;
};
constexpr CommonUnit kCommonUnits[] = {
    {kLength, 1.0, "m"},   {kLength, 0.01, "cm"}, {kLength, 0.001, "mm"},
    {kLength, 1e-6, "um"}, {kLength, 1e3, "km"},  {kAngle, std::numbers::pi / 180.0, "deg"},
    {kAngle, 1.0, "rad"},
};

// "mm", "30 mm", "10 deg", "rad/s": in the unit that takes the fewest digits.
std::string GetScaleName(double scale, const Dimension& dimension) {
  std::string digits, name;
  for (const CommonUnit& unit : kCommonUnits) {
    if (unit.dimension != dimension) continue;
    std::string number = fmt::format("{:.6g}", scale / unit.value);
    if (number == "1") return unit.name;
    if (!digits.empty() && number.size() >= digits.size()) continue;
    digits = std::move(number);
    name = unit.name;
  }
  if (!digits.empty()) return fmt::format("{} {}", digits, name);
  return scale == 1.0 ? UnitName(dimension) : FormatQuantity(scale, dimension);
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
  const bool is_one_word = name.find_first_of(" /*^") == std::string::npos;
  return fmt::format(" {}{}", is_one_word ? name : fmt::format("({})", name), *powers.begin() == 2 ? "²" : "");
}

}  // namespace knap
