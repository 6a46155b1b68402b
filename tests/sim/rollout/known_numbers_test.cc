#include "sim/rollout/known_numbers.h"

#include <gtest/gtest.h>

#include <cmath>

namespace knap {
namespace known_numbers_test {

TEST(KnownNumbersTest, AreFiniteAndTheSameEveryTime) {
  const std::vector<double> numbers = CalcKnownNumbers();
  for (std::size_t i = 0; i < numbers.size(); ++i) EXPECT_TRUE(std::isfinite(numbers[i])) << i;
  EXPECT_EQ(CalcKnownNumbers(), numbers);
}

// A rollout that touched nothing would prove nothing: both losses and their gradients have to be there.
TEST(KnownNumbersTest, HoldARolloutWithContact) {
  const std::vector<double> numbers = CalcKnownNumbers();
  const double* task = numbers.data() + numbers.size() - 8;  // loss, residual and two derivatives, twice
  const double* distillation = task + 4;
  EXPECT_GT(task[0], 1.0);
  EXPECT_GT(std::abs(task[3]), 100.0);  // the slant of the face turns the sphere aside
  EXPECT_GT(distillation[0], 0.0);
  EXPECT_GT(std::abs(distillation[3]), 1.0);
}

}  // namespace known_numbers_test
}  // namespace knap
