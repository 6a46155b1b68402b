#include "sim/scenarios/units.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>

namespace knap {
namespace {

struct UnitDefinition {
  std::string_view name;
  int decimal_exponent;  // the unit is factor·10^decimal_exponent SI units
  double factor;
  Dimension dimension;
};

constexpr Dimension kPressure{{-1, 1, -2, 0}};
constexpr Dimension kEnergy{{2, 1, -2, 0}};
constexpr Dimension kPower{{2, 1, -3, 0}};

constexpr UnitDefinition kUnits[] = {
    {"m", 0, 1.0, kLength},
    {"cm", -2, 1.0, kLength},
    {"mm", -3, 1.0, kLength},
    {"um", -6, 1.0, kLength},
    {"km", 3, 1.0, kLength},
    {"kg", 0, 1.0, kMass},
    {"g", -3, 1.0, kMass},
    {"mg", -6, 1.0, kMass},
    {"s", 0, 1.0, kTime},
    {"ms", -3, 1.0, kTime},
    {"us", -6, 1.0, kTime},
    {"min", 0, 60.0, kTime},
    {"rad", 0, 1.0, kAngle},
    {"mrad", -3, 1.0, kAngle},
    {"N", 0, 1.0, kForceDimension},
    {"deg", 0, std::numbers::pi / 180.0, kAngle},
    {"mN", -3, 1.0, kForceDimension},
    {"kN", 3, 1.0, kForceDimension},
    {"Pa", 0, 1.0, kPressure},
    {"kPa", 3, 1.0, kPressure},
    {"MPa", 6, 1.0, kPressure},
    {"J", 0, 1.0, kEnergy},
    {"mJ", -3, 1.0, kEnergy},
    {"W", 0, 1.0, kPower},
    {"Hz", 0, 1.0, {{0, 0, -1, 0}}},
};

// The units knap writes and asks for by name; any other dimension is written in powers of m, kg, s, rad.
struct DimensionDefinition {
  Dimension dimension;
  std::string_view unit;
  std::string_view noun;
  std::string_view example;
};

constexpr DimensionDefinition kDimensions[] = {
    {kLength, "m", "a length", "10 mm"},
    {kMass, "kg", "a mass", "4.2 g"},
    {kTime, "s", "a time", "2 ms"},
    {kAngle, "rad", "an angle", "90 deg"},
    {kSpeed, "m/s", "a speed", "60 mm/s"},
    {kAngularSpeed, "rad/s", "an angular speed", "90 deg/s"},
    {kAcceleration, "m/s^2", "an acceleration", "-9.81 m/s^2"},
    {kDensity, "kg/m^3", "a density", "1000 kg/m^3"},
    {kRotationalInertia, "kg*m^2", "a rotational inertia", "1e-6 kg*m^2"},
    {kForceDimension, "N", "a force", "2 N"},
    {kTorque, "N*m", "a torque", "0.06 N*m"},
    {kLinearStiffness, "N/m", "a stiffness", "100 N/m"},
    {kAngularStiffness, "N*m/rad", "a rotational stiffness", "0.1 N*m/rad"},
    {kAngularLimitDamping, "s/rad", "a damping relative to the elastic torque", "0.1 s/rad"},
    {kLinearDamping, "N*s/m", "a damping", "0.1 N*s/m"},
    {kAngularDamping, "N*m*s/rad", "a rotational damping", "1e-3 N*m*s/rad"},
    {kContactStiffness, "N/m^3", "a contact stiffness", "1e8 N/m^3"},
    {kContactDamping, "s/m", "a damping relative to the elastic force", "2 s/m"},
};

const DimensionDefinition* FindDimension(const Dimension& dimension) {
  const auto* found = std::find_if(std::begin(kDimensions), std::end(kDimensions),
                                   [&](const DimensionDefinition& d) { return d.dimension == dimension; });
  return found == std::end(kDimensions) ? nullptr : found;
}

bool IsDigit(char c) { return c >= '0' && c <= '9'; }
bool IsLetter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }

// Length of the run of digits that starts at `begin`.
std::size_t CountDigits(std::string_view text, std::size_t begin) {
  std::size_t end = begin;
  while (end < text.size() && IsDigit(text[end])) ++end;
  return end - begin;
}

// Splits off [-+]?integer from `text` at `pos`; empty when there is none or it has leading zeros.
std::string_view TakeInteger(std::string_view text, std::size_t& pos) {
  const std::size_t begin = pos;
  std::size_t p = pos;
  if (p < text.size() && (text[p] == '-' || text[p] == '+')) ++p;
  const std::size_t digits = CountDigits(text, p);
  if (digits == 0 || (digits > 1 && text[p] == '0')) return {};
  pos = p + digits;
  return text.substr(begin, pos - begin);
}

template <class Integer>
std::optional<Integer> ConvertInteger(std::string_view text) {
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  Integer value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

struct Unit {
  int decimal_exponent = 0;
  double factor = 1.0;
  Dimension dimension;
};

constexpr int kMaxPower = 9;

// name[^power], multiplied onto `unit` with the given sign of the power.
bool TakeUnitFactor(std::string_view text, std::size_t& pos, int sign, Unit& unit) {
  const std::size_t begin = pos;
  while (pos < text.size() && IsLetter(text[pos])) ++pos;
  const std::string_view name = text.substr(begin, pos - begin);
  // "1/s" is the only use of a number among the unit names.
  if (name.empty()) {
    if (begin != 0 || text.substr(0, 2) != "1/") return false;
    pos = 1;
    return true;
  }
  const auto* found =
      std::find_if(std::begin(kUnits), std::end(kUnits), [&](const UnitDefinition& u) { return u.name == name; });
  if (found == std::end(kUnits)) return false;
  int power = 1;
  if (pos < text.size() && text[pos] == '^') {
    ++pos;
    const std::optional<int> written = ConvertInteger<int>(TakeInteger(text, pos));
    if (!written || std::abs(*written) > kMaxPower) return false;
    power = *written;
  }
  power *= sign;
  unit.decimal_exponent += power * found->decimal_exponent;
  for (int i = 0; i < std::abs(power); ++i)
    unit.factor = power > 0 ? unit.factor * found->factor : unit.factor / found->factor;
  for (std::size_t i = 0; i < unit.dimension.exponents.size(); ++i) {
    unit.dimension.exponents[i] += power * found->dimension.exponents[i];
  }
  return true;
}

std::optional<Unit> ParseUnit(std::string_view text) {
  Unit unit;
  std::size_t pos = 0;
  if (!TakeUnitFactor(text, pos, 1, unit)) return std::nullopt;
  while (pos < text.size()) {
    const char op = text[pos++];
    if (op != '*' && op != '/') return std::nullopt;
    if (!TakeUnitFactor(text, pos, op == '*' ? 1 : -1, unit)) return std::nullopt;
  }
  return unit;
}

}  // namespace

std::optional<std::int64_t> ParseInteger(std::string_view text) {
  std::size_t pos = 0;
  const std::string_view integer = TakeInteger(text, pos);
  if (integer.empty() || pos != text.size()) return std::nullopt;
  return ConvertInteger<std::int64_t>(integer);
}

std::optional<Quantity> ParseQuantity(std::string_view text) {
  std::size_t pos = 0;
  if (TakeInteger(text, pos).empty()) return std::nullopt;
  if (pos < text.size() && text[pos] == '.') {
    const std::size_t digits = CountDigits(text, pos + 1);
    if (digits == 0) return std::nullopt;
    pos += 1 + digits;
  }
  std::string_view mantissa = text.substr(0, pos);
  if (mantissa.front() == '+') mantissa.remove_prefix(1);
  std::int64_t exponent = 0;
  if (pos < text.size() && (text[pos] == 'e' || text[pos] == 'E')) {
    // "1e-06" is what many programs print: leading zeros cannot be misread here.
    std::size_t p = pos + 1;
    const bool negative = p < text.size() && text[p] == '-';
    if (p < text.size() && (text[p] == '-' || text[p] == '+')) ++p;
    const std::size_t digits = CountDigits(text, p);
    const std::optional<int> magnitude = ConvertInteger<int>(text.substr(p, digits));
    if (!magnitude) return std::nullopt;
    exponent = negative ? -std::int64_t{*magnitude} : *magnitude;
    pos = p + digits;
  }

  Unit unit;
  if (pos < text.size()) {
    if (text[pos] != ' ') return std::nullopt;
    while (pos < text.size() && text[pos] == ' ') ++pos;
    const std::optional<Unit> parsed = ParseUnit(text.substr(pos));
    if (!parsed) return std::nullopt;
    unit = *parsed;
  }

  const std::string shifted = fmt::format("{}e{}", mantissa, exponent + unit.decimal_exponent);
  Quantity quantity;
  quantity.dimension = unit.dimension;
  const auto [end, error] = std::from_chars(shifted.data(), shifted.data() + shifted.size(), quantity.value);
  if (error != std::errc() || end != shifted.data() + shifted.size()) return std::nullopt;
  quantity.value *= unit.factor;
  if (!std::isfinite(quantity.value)) return std::nullopt;
  return quantity;
}

std::string UnitName(const Dimension& dimension) {
  if (const DimensionDefinition* known = FindDimension(dimension)) return std::string(known->unit);
  constexpr std::string_view kNames[] = {"m", "kg", "s", "rad"};
  std::string name;
  for (std::size_t i = 0; i < dimension.exponents.size(); ++i) {
    if (dimension.exponents[i] == 0) continue;
    if (!name.empty()) name += '*';
    name += fmt::format("{}^{}", kNames[i], dimension.exponents[i]);
  }
  return name;
}

std::string FormatQuantity(double value, const Dimension& dimension) {
  char buffer[32];
  const auto [end, error] = std::to_chars(std::begin(buffer), std::end(buffer), value);
  static_cast<void>(error);  // the shortest form of a double has at most 24 characters
  std::string text(buffer, end);
  const std::string unit = UnitName(dimension);
  return unit.empty() ? text : text + " " + unit;
}

std::string DescribeQuantity(const Dimension& dimension) {
  if (dimension == kDimensionless) return "a number without a unit, such as '0.4'";
  if (const DimensionDefinition* known = FindDimension(dimension)) {
    return fmt::format("{} with its unit, such as '{}'", known->noun, known->example);
  }
  return fmt::format("a number in {}", UnitName(dimension));
}

}  // namespace knap
