// Numbers with units, as scenario files write them: "10 mm", "-9.81 m/s^2", "0.4".
//
// A quantity is a decimal number, then, unless it is dimensionless, blanks and a unit: unit names joined by * and /,
// each with an optional integer power; / divides by the one name that follows it ("N*m*s/rad"). Angles are a dimension
// of their own, so that "180" cannot stand for 180 deg or 180 rad unnoticed.
//
// Decimal prefixes shift the number's exponent before it is converted: "10 mm" is the double nearest to 0.01.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace knap {

// Exponents of m, kg, s and rad.
struct Dimension {
  std::array<int, 4> exponents{};

  bool operator==(const Dimension&) const = default;
};

inline constexpr Dimension kDimensionless{};
inline constexpr Dimension kLength{{1, 0, 0, 0}};
inline constexpr Dimension kVolume{{3, 0, 0, 0}};
inline constexpr Dimension kMass{{0, 1, 0, 0}};
inline constexpr Dimension kTime{{0, 0, 1, 0}};
inline constexpr Dimension kAngle{{0, 0, 0, 1}};
inline constexpr Dimension kSpeed{{1, 0, -1, 0}};
inline constexpr Dimension kAngularSpeed{{0, 0, -1, 1}};
inline constexpr Dimension kAcceleration{{1, 0, -2, 0}};
inline constexpr Dimension kDensity{{-3, 1, 0, 0}};
inline constexpr Dimension kRotationalInertia{{2, 1, 0, 0}};
inline constexpr Dimension kForceDimension{{1, 1, -2, 0}};       // N
inline constexpr Dimension kTorque{{2, 1, -2, 0}};               // N·m
inline constexpr Dimension kLinearStiffness{{0, 1, -2, 0}};      // N/m
inline constexpr Dimension kAngularStiffness{{2, 1, -2, -1}};    // N·m/rad
inline constexpr Dimension kAngularLimitDamping{{0, 0, 1, -1}};  // s/rad
inline constexpr Dimension kLinearDamping{{0, 1, -1, 0}};        // N·s/m
inline constexpr Dimension kAngularDamping{{2, 1, -1, -1}};      // N·m·s/rad
inline constexpr Dimension kContactStiffness{{-2, 1, -2, 0}};    // N/m³
inline constexpr Dimension kContactDamping{{-1, 0, 1, 0}};       // s/m; also of a prismatic joint's limit

struct Quantity {
  double value = 0.0;  // SI
  Dimension dimension;
};

// Empty when `text` is not a finite decimal number with an optional unit of known names. A number has no leading zeros
// and digits on both sides of its point.
std::optional<Quantity> ParseQuantity(std::string_view text);

// Empty when `text` is not an integer without leading zeros in the range of int64.
std::optional<std::int64_t> ParseInteger(std::string_view text);

// The unit in which FormatQuantity writes: "m", "N/m^3"; empty for kDimensionless. Its scale is exactly 1.
std::string UnitName(const Dimension& dimension);

// The shortest text that ParseQuantity turns into the same bits. `value` is finite.
std::string FormatQuantity(double value, const Dimension& dimension);

// What a reader is told to write: "a length with its unit, such as '10 mm'"; "a number without a unit".
std::string DescribeQuantity(const Dimension& dimension);

}  // namespace knap
