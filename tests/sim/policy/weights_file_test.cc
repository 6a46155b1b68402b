// Weights written and read back to the last bit, and what is refused, with its place.
#include "sim/policy/weights_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

namespace knap {
namespace {

TEST(WeightsFile, ComesBackToTheLastBit) {
  Eigen::VectorXd weights(5);
  weights << 0.1, -1.0 / 3.0, 0.0, 5e-324, -1.9999999999999998;
  const std::string text = FormatWeights(weights, "learned");
  EXPECT_EQ(text.substr(0, 10), "# learned\n");
  EXPECT_EQ(ParseWeights(text, "w.txt", 5, -2.0, 2.0), weights);
  EXPECT_EQ(ParseWeights(" 1\t-0.5 # and so on 7\n\r\n2", "w.txt", 3, -2.0, 2.0), Eigen::Vector3d(1.0, -0.5, 2.0));
}

std::string FindError(const std::string& text) {
  try {
    ParseWeights(text, "w.txt", 2, -2.0, 2.0);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "none";
}

TEST(WeightsFile, IsRefusedWithThePlace) {
  EXPECT_EQ(FindError("1 2"), "none");
  EXPECT_EQ(FindError("1\n 2x"), "w.txt:2:2: value '2x': expected a weight, a decimal number");
  EXPECT_EQ(FindError("nan 1"), "w.txt:1:1: value 'nan': expected a weight, a decimal number");
  EXPECT_EQ(FindError("1, 2"), "w.txt:1:1: value '1,': expected a weight, a decimal number");
  EXPECT_EQ(FindError("1 2.5"), "w.txt:1:3: value '2.5': must lie from lower, -2, to upper, 2");
  EXPECT_EQ(FindError("1 2\n1"), "w.txt:2:1: value '1': one weight too many; the policy's network has 2");
  EXPECT_EQ(FindError("# none\n1\n"), "w.txt:3:1: has 1 weights; the policy's network has 2");
  EXPECT_EQ(FindError(""), "w.txt:1:1: has 0 weights; the policy's network has 2");
}

}  // namespace
}  // namespace knap
