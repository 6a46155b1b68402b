#include "sim/scenarios/units.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <numbers>

namespace knap {
namespace units_test {

double ParseAs(const std::string& text, const Dimension& dimension) {
  const std::optional<Quantity> quantity = ParseQuantity(text);
  EXPECT_TRUE(quantity.has_value()) << text;
  if (!quantity) return std::nan("");
  EXPECT_EQ(quantity->dimension, dimension) << text;
  return quantity->value;
}

// Each decimal is the double nearest to the SI number, so equality is exact.
TEST(ParseQuantity, ConvertsToTheNearestSiDouble) {
  EXPECT_EQ(ParseAs("10 mm", kLength), 0.01);
  EXPECT_EQ(ParseAs("4.2 g", kMass), 0.0042);
  EXPECT_EQ(ParseAs("-9.81 m/s^2", kAcceleration), -9.81);
  EXPECT_EQ(ParseAs("60 mm/s", kSpeed), 0.06);
  EXPECT_EQ(ParseAs("1.3e8 N/m^3", kContactStiffness), 1.3e8);
  EXPECT_EQ(ParseAs("1e-3 N*m*s/rad", kAngularDamping), 1e-3);
  EXPECT_EQ(ParseAs("0.4", kDimensionless), 0.4);
  EXPECT_EQ(ParseAs("+3 km", kLength), 3000.0);
  EXPECT_EQ(ParseAs("2   cm", kLength), 0.02);
  EXPECT_EQ(ParseAs("1 g/cm^3", kDensity), 1000.0);
  EXPECT_EQ(ParseAs("2 min", kTime), 120.0);
  EXPECT_EQ(ParseAs("5 m*s^-1", kSpeed), 5.0);
  EXPECT_EQ(ParseAs("3 1/s", Dimension({0, 0, -1, 0})), 3.0);
  EXPECT_EQ(ParseAs("3 Hz", Dimension({0, 0, -1, 0})), 3.0);
  EXPECT_EQ(ParseAs("1e-06 m", kLength), 1e-6);
  EXPECT_DOUBLE_EQ(ParseAs("180 deg", kAngle), std::numbers::pi);
}

TEST(ParseQuantity, TellsAnglesFromNumbers) {
  EXPECT_NE(ParseQuantity("1 rad")->dimension, ParseQuantity("1")->dimension);
  EXPECT_NE(ParseQuantity("1 rad/s")->dimension, ParseQuantity("1 1/s")->dimension);
}

class NotAQuantity : public testing::TestWithParam<const char*> {};

TEST_P(NotAQuantity, IsRefused) { EXPECT_FALSE(ParseQuantity(GetParam()).has_value()); }

INSTANTIATE_TEST_SUITE_P(All, NotAQuantity,
                         testing::Values("", "mm", "010", "00", "1.", ".5", "0x10", "1_000", "1,5", "nan", "inf",
                                         "1e400", "1e", "1 ", "1 mm mm", "1mm", "1 xm", "1 m/", "1 m//s", "1 m^",
                                         "1 m^0x2", "1 m^99", "- 1", "--1", "1 1", "1 m s", "1\tm", "yes", "1 2/s",
                                         "1e99999999999 m", "1 m*1/s*1/s"));

TEST(ParseInteger, IsStrict) {
  EXPECT_EQ(ParseInteger("0"), 0);
  EXPECT_EQ(ParseInteger("-12"), -12);
  EXPECT_EQ(ParseInteger("+7"), 7);
  EXPECT_EQ(ParseInteger("9223372036854775807"), INT64_MAX);
  for (const char* text : {"", "010", "1.0", "1e3", "9223372036854775808", "0x1", " 1", "1 ", "+", "+-1", "yes"}) {
    EXPECT_FALSE(ParseInteger(text).has_value()) << text;
  }
}

TEST(FormatQuantity, WritesSiUnits) {
  EXPECT_EQ(FormatQuantity(0.01, kLength), "0.01 m");
  EXPECT_EQ(FormatQuantity(-0.0, kDimensionless), "-0");
  EXPECT_EQ(FormatQuantity(1.0 / 3.0, kMass), "0.3333333333333333 kg");
  EXPECT_EQ(FormatQuantity(2.0, Dimension({2, -1, 0, 3})), "2 m^2*kg^-1*rad^3");
}

constexpr Dimension kSomeDimensions[] = {kDimensionless,
                                         kLength,
                                         kMass,
                                         kTime,
                                         kAngle,
                                         kAcceleration,
                                         kDensity,
                                         kRotationalInertia,
                                         kContactStiffness,
                                         kAngularDamping,
                                         kLinearDamping,
                                         kContactDamping,
                                         {{2, -1, 0, 3}},
                                         {{-3, 0, 0, 0}}};

RC_GTEST_PROP(FormatQuantity, ReadsBackBitForBit, (std::uint64_t bits)) {
  const double value = std::bit_cast<double>(bits);
  RC_PRE(std::isfinite(value));
  for (const Dimension& dimension : kSomeDimensions) {
    const std::optional<Quantity> quantity = ParseQuantity(FormatQuantity(value, dimension));
    RC_ASSERT(quantity.has_value());
    RC_ASSERT(std::bit_cast<std::uint64_t>(quantity->value) == bits);
    RC_ASSERT(quantity->dimension == dimension);
  }
}

RC_GTEST_PROP(ParseQuantity, SurvivesAnyText, (const std::string& text)) {
  const std::optional<Quantity> quantity = ParseQuantity(text);
  RC_ASSERT(!quantity || std::isfinite(quantity->value));
}

}  // namespace units_test
}  // namespace knap
