#include "sim/scenarios/nearest_name.h"

#include <gtest/gtest.h>

#include <vector>

namespace knap {
namespace nearest_name_test {

TEST(CalcEditDistance, CountsEdits) {
  EXPECT_EQ(CalcEditDistance("", ""), 0u);
  EXPECT_EQ(CalcEditDistance("", "abc"), 3u);
  EXPECT_EQ(CalcEditDistance("kitten", "sitting"), 3u);
  EXPECT_EQ(CalcEditDistance("batch", "bacth"), 1u);  // neighbours swapped
  EXPECT_EQ(CalcEditDistance("batch", "bach"), 1u);
  EXPECT_EQ(CalcEditDistance("ca", "abc"), 3u);  // optimal string alignment edits no place twice
}

TEST(FindNearestName, SuggestsOnlyWhatIsNear) {
  const std::vector<std::string> names{"batch", "variations", "alpha"};
  EXPECT_EQ(FindNearestName("bacth", names), "batch");
  EXPECT_EQ(FindNearestName("variation", names), "variations");
  EXPECT_EQ(FindNearestName("horizon", names), "");
  EXPECT_EQ(FindNearestName("", names), "");
}

}  // namespace nearest_name_test
}  // namespace knap
