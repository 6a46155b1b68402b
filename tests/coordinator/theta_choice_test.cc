#include "coordinator/cli/theta_choice.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "coordinator/run/usage_error.h"

namespace knap {
namespace theta_choice_test {

const ParameterSpec kSpec{{"width", "depth"}, {0.01, -0.02}, {0.05, 0.02}, {0.03, 0.0}, {"m", "m"}};

std::vector<std::vector<double>> Choose(const std::string& text, std::uint64_t seed = 0,
                                        const std::string& by_default = "initial") {
  return ChooseThetas(text, kSpec, seed, {by_default, [] { return std::vector<double>{0.04, 0.01}; }});
}

TEST(ThetaChoiceTest, NamesAndAssignments) {
  using Thetas = std::vector<std::vector<double>>;
  EXPECT_EQ(Choose("initial"), (Thetas{{0.03, 0.0}}));
  EXPECT_EQ(Choose("learned"), (Thetas{{0.04, 0.01}}));
  EXPECT_EQ(Choose("depth=-12.5 mm"), (Thetas{{0.03, -0.0125}}));
  EXPECT_EQ(Choose("depth=1 cm,width=20 mm"), (Thetas{{0.02, 0.01}}));
}

TEST(ThetaChoiceTest, OfARunWhatIsNotNamedStaysLearned) {
  using Thetas = std::vector<std::vector<double>>;
  EXPECT_EQ(Choose("", 0, "learned"), (Thetas{{0.04, 0.01}}));
  EXPECT_EQ(Choose("depth=-12.5 mm", 0, "learned"), (Thetas{{0.04, -0.0125}}));
  EXPECT_EQ(Choose("initial", 0, "learned"), (Thetas{{0.03, 0.0}}));
  EXPECT_EQ(Choose("", 0, "initial"), (Thetas{{0.03, 0.0}}));
}

TEST(ThetaChoiceTest, RandomDesignsLieWithinTheBoundsAndDependOnTheSeed) {
  const auto thetas = Choose("random:50");
  ASSERT_EQ(thetas.size(), 50u);
  for (const auto& theta : thetas) {
    for (std::size_t i = 0; i < 2; ++i) {
      EXPECT_GE(theta[i], kSpec.lower[i]);
      EXPECT_LE(theta[i], kSpec.upper[i]);
    }
  }
  EXPECT_EQ(Choose("random:50"), thetas);
  EXPECT_NE(Choose("random:50", 1), thetas);
  EXPECT_EQ(Choose("random:3")[2], thetas[2]);
}

TEST(ThetaChoiceTest, ErrorsSayWhatIsAllowed) {
  const auto expect_error = [](const std::string& text, const std::string& part) {
    try {
      Choose(text);
      ADD_FAILURE() << text << " was accepted";
    } catch (const UsageError& e) {
      EXPECT_THAT(e.what(), ::testing::HasSubstr(part)) << text;
    }
  };
  expect_error("best", "NAME=VALUE");
  expect_error("height=1 mm", "no parameter 'height'");
  expect_error("width=30", "length");
  expect_error("width=30 kg", "length");
  expect_error("width=30 mm,", "NAME=VALUE");
  expect_error("random:0", "1 to");
  expect_error("random:many", "1 to");
}

}  // namespace theta_choice_test
}  // namespace knap
