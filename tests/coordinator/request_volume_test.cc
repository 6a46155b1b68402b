#include "coordinator/run/request_volume.h"

#include <gtest/gtest.h>

#include <limits>

#include "coordinator/run/usage_error.h"

namespace knap {
namespace request_volume_test {

TEST(RequestVolumeTest, AllowsWhatFitsIntoMemory) {
  EXPECT_NO_THROW(CheckRequestVolume("--grid", {1000.0, 1000.0, 10.0}, 25));
  EXPECT_NO_THROW(CheckRequestVolume("--variations", {200.0, 1.0}, 400000));
}

TEST(RequestVolumeTest, RefusesProductsThatOverflow) {
  const auto error = [](std::initializer_list<double> counts, std::size_t values) {
    try {
      CheckRequestVolume("--grid and --variations", counts, values);
    } catch (const UsageError& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  EXPECT_EQ(error({1000.0, 1000.0, 1e6}, 9),
            "--grid and --variations: 1000000000000 rollouts at once, at most 10000000 are allowed");
  EXPECT_EQ(error({1e6}, 400000),
            "--grid and --variations: 1000000 rollouts at once with 400000 numbers each, at most 250000000 numbers are "
            "allowed");
  const double most = std::numeric_limits<double>::max();
  EXPECT_NE(error({most, most, most}, 1), "");
}

}  // namespace request_volume_test
}  // namespace knap
