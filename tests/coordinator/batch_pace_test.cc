#include "coordinator/dispatch/batch_pace.h"

#include <gtest/gtest.h>

#include "lcmtypes/wire/channels.h"

namespace knap {
namespace batch_pace_test {

TEST(BatchPaceTest, StragglesAfterThreeQuartersAndOneAndAHalfMedians) {
  BatchPace pace;
  pace.Begin(8);
  EXPECT_FALSE(pace.IsStraggling(1'000'000'000, 1));  // nothing is known yet
  for (const std::int64_t duration_us : {100'000, 300'000, 200'000}) pace.Record(duration_us);
  EXPECT_EQ(pace.CalcMedianUs(), 200'000);
  EXPECT_FALSE(pace.IsStraggling(320'000, 2));
  EXPECT_TRUE(pace.IsStraggling(320'001, 2));
  EXPECT_FALSE(pace.IsStraggling(320'001, 3));
  EXPECT_FALSE(pace.IsStraggling(20'000, 1));
}

TEST(BatchPaceTest, OneSlowRolloutDoesNotMoveTheMedian) {
  BatchPace pace;
  for (int i = 0; i < 1000; ++i) pace.Record(i % 10 == 0 ? 5'000'000 : 1000);
  EXPECT_EQ(pace.CalcMedianUs(), 1000);
}

TEST(BatchPaceTest, CreditsAreWorthTwentyMilliseconds) {
  BatchPace pace;
  EXPECT_EQ(pace.CalcCredits(2), 2);
  pace.Record(50'000);
  EXPECT_EQ(pace.CalcCredits(2), 2);
  pace = BatchPace();
  pace.Record(4000);
  EXPECT_EQ(pace.CalcCredits(2), 5);
  pace = BatchPace();
  pace.Record(0);
  EXPECT_EQ(pace.CalcCredits(2), kMaxQueue);
}

}  // namespace batch_pace_test
}  // namespace knap
