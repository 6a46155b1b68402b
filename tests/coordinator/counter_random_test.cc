#include "coordinator/random/counter_random.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <stdexcept>

namespace knap {
namespace counter_random_test {

// The known answers that the authors of Philox publish with Random123 (kat_vectors, "philox4x32 10").
TEST(CounterRandomTest, PhiloxGivesThePublishedAnswers) {
  using Block = std::array<std::uint32_t, 4>;
  EXPECT_EQ(CalcPhilox4x32({0, 0, 0, 0}, {0, 0}), (Block{0x6627e8d5u, 0xe169c58du, 0xbc57ac4cu, 0x9b00dbd8u}));
  EXPECT_EQ(CalcPhilox4x32({0xffffffffu, 0xffffffffu, 0xffffffffu, 0xffffffffu}, {0xffffffffu, 0xffffffffu}),
            (Block{0x408f276du, 0x41c83b0eu, 0xa20bc7c6u, 0x6d5451fdu}));
  EXPECT_EQ(CalcPhilox4x32({0x243f6a88u, 0x85a308d3u, 0x13198a2eu, 0x03707344u}, {0xa4093822u, 0x299f31d0u}),
            (Block{0xd16cfe09u, 0x94fdccebu, 0x5001e420u, 0x24126ea1u}));
}

TEST(CounterRandomTest, NumbersDependOnSeedStreamAndIndexAlone) {
  CounterRandom first(7, RandomStream::kTrainingVariations, 3);
  CounterRandom other(7, RandomStream::kTrainingVariations, 4);
  other.DrawBits();  // draws elsewhere change nothing here
  CounterRandom again(7, RandomStream::kTrainingVariations, 3);
  for (int i = 0; i < 9; ++i) EXPECT_EQ(first.DrawBits(), again.DrawBits());
}

TEST(CounterRandomTest, SeedsStreamsAndIndicesNeverShareANumber) {
  std::set<std::uint64_t> seen;
  std::size_t drawn = 0;
  for (const std::uint64_t seed : {0ull, 1ull, 1ull << 32}) {
    for (const RandomStream stream :
         {RandomStream::kTrainingVariations, RandomStream::kTestVariations, RandomStream::kDistillation,
          RandomStream::kFirstBatch, RandomStream::kRandomThetas, RandomStream::kOptimizer}) {
      for (const std::uint64_t index : {0ull, 1ull, 2ull, 1ull << 32, ~0ull}) {
        CounterRandom random(seed, stream, index);
        for (int i = 0; i < 20; ++i, ++drawn) seen.insert(random.DrawBits());
      }
    }
  }
  EXPECT_EQ(seen.size(), drawn);  // a chance collision of 1800 64-bit numbers has probability 1e-13
}

TEST(CounterRandomTest, UniformHasTheRightMoments) {
  constexpr int kDraws = 100000;
  CounterRandom random(1, RandomStream::kTestVariations, 0);
  double sum = 0.0, sum_squares = 0.0;
  for (int i = 0; i < kDraws; ++i) {
    const double u = random.DrawUniform();
    ASSERT_GE(u, 0.0);
    ASSERT_LT(u, 1.0);
    sum += u;
    sum_squares += u * u;
  }
  // Five standard errors: sqrt(1/12/n) = 9.1e-4 and sqrt(4/45/n) = 9.4e-4.
  EXPECT_NEAR(sum / kDraws, 0.5, 5 * 9.1e-4);
  EXPECT_NEAR(sum_squares / kDraws, 1.0 / 3.0, 5 * 9.4e-4);
}

TEST(CounterRandomTest, UniformOnAnIntervalStaysInside) {
  CounterRandom random(2, RandomStream::kTestVariations, 0);
  for (int i = 0; i < 1000; ++i) {
    const double u = random.DrawUniform(-0.02, 0.03);
    ASSERT_GE(u, -0.02);
    ASSERT_LE(u, 0.03);
  }
  EXPECT_EQ(random.DrawUniform(0.1, 0.1), 0.1);
}

// Against libm's complementary error function: Phi(z) = erfc(-z / sqrt 2) / 2. The slope of Phi bounds what an error of
// z does: |Phi(z) - p| = phi(z) |dz|, and erfc itself is good to a few 1e-16 relative.
TEST(CounterRandomTest, NormalQuantileInvertsTheNormalDistribution) {
  for (int i = -3000; i <= 3000; ++i) {
    const double p = i < 0 ? std::pow(10.0, i / 10.0) : i / 3001.0;
    if (p <= 0.0 || !std::isnormal(p)) continue;
    const double z = CalcNormalQuantile(p);
    const double back = 0.5 * std::erfc(-z / std::sqrt(2.0));
    // d log Phi / dz is about |z| in the lower tail, so an error of 1e-15 z shows as 1e-15 z² relative.
    EXPECT_NEAR(back / p, 1.0, 4e-15 * (1.0 + z * z)) << "p = " << p;
  }
  EXPECT_EQ(CalcNormalQuantile(0.5), 0.0);
  EXPECT_EQ(CalcNormalQuantile(0.25), -CalcNormalQuantile(0.75));
  EXPECT_NEAR(CalcNormalQuantile(0.975), 1.959963984540054, 1e-14);
  EXPECT_THROW(CalcNormalQuantile(0.0), std::invalid_argument);
  EXPECT_THROW(CalcNormalQuantile(1.0), std::invalid_argument);
}

TEST(CounterRandomTest, NormalHasTheRightMoments) {
  constexpr int kDraws = 100000;
  CounterRandom random(3, RandomStream::kTestVariations, 0);
  double m1 = 0.0, m2 = 0.0, m4 = 0.0;
  for (int i = 0; i < kDraws; ++i) {
    const double z = random.DrawNormal();
    m1 += z;
    m2 += z * z;
    m4 += z * z * z * z;
  }
  // Standard errors: 1/sqrt n, sqrt(2/n), sqrt(96/n).
  EXPECT_NEAR(m1 / kDraws, 0.0, 5 * 3.2e-3);
  EXPECT_NEAR(m2 / kDraws, 1.0, 5 * 4.5e-3);
  EXPECT_NEAR(m4 / kDraws, 3.0, 5 * 3.1e-2);
}

TEST(CounterRandomTest, LowerTailInvertsTheQuantile) {
  // Phi(-1), Phi(-3) from tables with 15 digits.
  EXPECT_NEAR(CalcNormalLowerTail(-1.0), 0.158655253931457, 1e-15);
  EXPECT_NEAR(CalcNormalLowerTail(-3.0), 0.001349898031630, 1e-15);
  EXPECT_EQ(CalcNormalLowerTail(-std::numeric_limits<double>::infinity()), 0.0);
}

TEST(CounterRandomTest, TruncatedNormalStaysWithinItsLimitAndHasItsVariance) {
  constexpr int kDraws = 100000;
  CounterRandom random(3, RandomStream::kTestVariations, 1);
  double m1 = 0.0, m2 = 0.0, largest = 0.0;
  for (int i = 0; i < kDraws; ++i) {
    const double z = random.DrawTruncatedNormal(1.0);
    m1 += z;
    m2 += z * z;
    largest = std::max(largest, std::abs(z));
  }
  // 1 - 2 phi(1) / (2 Phi(1) - 1) = 0.291125; standard errors sqrt(0.2911/n) and below sqrt(0.1/n).
  EXPECT_NEAR(m1 / kDraws, 0.0, 5 * 1.7e-3);
  EXPECT_NEAR(m2 / kDraws, 0.291125, 5 * 1.0e-3);
  EXPECT_LE(largest, 1.0);
  EXPECT_GT(largest, 0.999);
  EXPECT_THROW(random.DrawTruncatedNormal(0.0), std::invalid_argument);
}

TEST(CounterRandomTest, WideLimitsLeaveTheNormalAsItIs) {
  CounterRandom plain(3, RandomStream::kTestVariations, 2), unlimited = plain, wide = plain;
  for (int i = 0; i < 1000; ++i) {
    const double z = plain.DrawNormal();
    EXPECT_EQ(unlimited.DrawTruncatedNormal(std::numeric_limits<double>::infinity()), z);
    EXPECT_NEAR(wide.DrawTruncatedNormal(8.0), z, 1e-12);
  }
}

TEST(CounterRandomTest, DrawsWithoutReplacementAreEquallyLikely) {
  std::map<std::vector<std::uint64_t>, int> counts;
  constexpr int kRounds = 12000;
  for (int i = 0; i < kRounds; ++i) {
    CounterRandom random(4, RandomStream::kDistillation, static_cast<std::uint64_t>(i));
    ++counts[random.DrawWithoutReplacement(4, 2)];
  }
  ASSERT_EQ(counts.size(), 12u);  // 4 · 3 ordered pairs, none with a repeat
  for (const auto& [pair, count] : counts) {
    EXPECT_NE(pair[0], pair[1]);
    EXPECT_NEAR(count, kRounds / 12, 5 * std::sqrt(kRounds / 12.0));
  }
  CounterRandom random(4, RandomStream::kDistillation, 0);
  EXPECT_EQ(random.DrawWithoutReplacement(5, 0).size(), 0u);
  EXPECT_THROW(random.DrawWithoutReplacement(3, 4), std::invalid_argument);
}

TEST(CounterRandomTest, DrawBelowCoversItsRangeEvenly) {
  CounterRandom random(5, RandomStream::kDistillation, 0);
  std::array<int, 7> counts{};
  for (int i = 0; i < 70000; ++i) ++counts[random.DrawBelow(7)];
  for (const int count : counts) EXPECT_NEAR(count, 10000, 5 * 93);
  EXPECT_EQ(random.DrawBelow(1), 0u);
  // For 3/4 of 2^64 a bare remainder would favour the lowest third by two to one.
  const std::uint64_t bound = 3ull << 62;
  int low = 0;
  for (int i = 0; i < 30000; ++i) low += random.DrawBelow(bound) < (1ull << 62) ? 1 : 0;
  EXPECT_NEAR(low, 10000, 5 * 82);
  EXPECT_THROW(random.DrawBelow(0), std::invalid_argument);
}

}  // namespace counter_random_test
}  // namespace knap
