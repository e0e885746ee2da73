#include "gateway/service/rounds.hpp"

#include <gtest/gtest.h>

namespace motionlab::service {
namespace {

TEST(RoundsCheck, IsSatisfiedOnlyWhenEveryThreadCameRound) {
  RoundsCheck check;
  EXPECT_FALSE(check.all_came_round({0, 0, 0}));
  EXPECT_EQ(check.silent(), "io, control, bus");
  EXPECT_FALSE(check.all_came_round({5, 7, 0}));
  EXPECT_EQ(check.silent(), "bus");
  EXPECT_TRUE(check.all_came_round({5, 7, 1}));
  EXPECT_EQ(check.silent(), "");
}

TEST(RoundsCheck, AsksAnewAfterEachAnswer) {
  RoundsCheck check;
  ASSERT_TRUE(check.all_came_round({1, 1, 1}));
  EXPECT_FALSE(check.all_came_round({1, 1, 1}));
  // One thread hangs for good: the others do not make up for it.
  for (std::uint64_t round = 2; round < 100; ++round) {
    EXPECT_FALSE(check.all_came_round({1, round, round}));
    EXPECT_EQ(check.silent(), "io");
  }
  EXPECT_TRUE(check.all_came_round({2, 100, 100}));
}

}  // namespace
}  // namespace motionlab::service
