#include "drivers/core/random.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace motionlab {
namespace {

TEST(SplitMix, GivesThePublishedSequence) {
  // Published: the first values for seed 1234567 (Rosetta Code, "Pseudo-random numbers/Splitmix64").
  std::uint64_t state = 1234567;
  EXPECT_EQ(split_mix(state), 6457827717110365317u);
  EXPECT_EQ(split_mix(state), 3203168211198807973u);
  EXPECT_EQ(split_mix(state), 9817491932198370423u);
  EXPECT_EQ(split_mix(state), 4593380528125082431u);
  EXPECT_EQ(split_mix(state), 16408922859458223821u);
}

TEST(Random, GivesTheSameForTheSameSeedAndOtherwiseNot) {
  Random a(1);
  Random b(1);
  Random c(2);
  for (int i = 0; i < 100; ++i) {
    const auto bits = a.bits();
    EXPECT_EQ(bits, b.bits());
    EXPECT_NE(bits, c.bits());
  }
}

TEST(Random, StreamsOfOneSeedAreUnrelated) {
  Random a(1, "mru1/heave");
  Random b(1, "mru2/heave");
  double product = 0.0;
  for (int i = 0; i < 100000; ++i) product += a.normal() * b.normal();
  EXPECT_NEAR(product / 100000, 0.0, 0.015);
}

TEST(Random, UniformFillsItsIntervalEvenly) {
  Random random(3);
  double sum = 0.0;
  double sum_of_squares = 0.0;
  constexpr int kMany = 200000;
  for (int i = 0; i < kMany; ++i) {
    const double x = random.uniform();
    ASSERT_GE(x, 0.0);
    ASSERT_LT(x, 1.0);
    sum += x;
    sum_of_squares += x * x;
  }
  EXPECT_NEAR(sum / kMany, 0.5, 0.003);
  EXPECT_NEAR(sum_of_squares / kMany, 1.0 / 3.0, 0.003);
}

TEST(Random, NormalHasTheMomentsOfANormal) {
  Random random(4);
  double moments[4] = {};
  constexpr int kMany = 400000;
  int beyond_two_sigma = 0;
  for (int i = 0; i < kMany; ++i) {
    const double x = random.normal();
    moments[0] += x;
    moments[1] += x * x;
    moments[2] += x * x * x;
    moments[3] += x * x * x * x;
    beyond_two_sigma += std::abs(x) > 2.0;
  }
  EXPECT_NEAR(moments[0] / kMany, 0.0, 0.007);
  EXPECT_NEAR(moments[1] / kMany, 1.0, 0.01);
  EXPECT_NEAR(moments[2] / kMany, 0.0, 0.02);
  EXPECT_NEAR(moments[3] / kMany, 3.0, 0.06);
  EXPECT_NEAR(static_cast<double>(beyond_two_sigma) / kMany, 0.0455, 0.0015);
}

TEST(Random, ExponentialHasItsMeanAndItsTail) {
  Random random(5);
  double sum = 0.0;
  int beyond_three = 0;
  constexpr int kMany = 200000;
  for (int i = 0; i < kMany; ++i) {
    const double x = random.exponential(2.0);
    ASSERT_GE(x, 0.0);
    sum += x;
    beyond_three += x > 6.0;
  }
  EXPECT_NEAR(sum / kMany, 2.0, 0.02);
  EXPECT_NEAR(static_cast<double>(beyond_three) / kMany, std::exp(-3.0), 0.002);
}

TEST(Random, BelowReachesEveryNumberAndNoMore) {
  Random random(6);
  int seen[7] = {};
  for (int i = 0; i < 70000; ++i) {
    const auto n = random.below(7);
    ASSERT_LT(n, 7u);
    ++seen[n];
  }
  for (const int n : seen) EXPECT_NEAR(n, 10000, 400);
}

TEST(Random, ZeroAndOneAreCertain) {
  Random random(7);
  for (int i = 0; i < 1000; ++i) {
    EXPECT_FALSE(random.chance(0.0));
    EXPECT_TRUE(random.chance(1.0));
  }
}

}  // namespace
}  // namespace motionlab
