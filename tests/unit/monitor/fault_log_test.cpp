#include "gateway/monitor/fault_log.hpp"

#include <gtest/gtest.h>

#include "tests/unit/monitor/samples.hpp"

namespace motionlab::monitor {
namespace {

using topic::ModeState;

TEST(FaultLog, NamesAnUncausedFaultByItsCode) {
  FaultLog log;
  log.take(mode(ModeState::fault, 30, "mru1_stale"));
  ASSERT_EQ(log.entries().size(), 1u);
  EXPECT_EQ(log.entries()[0].name, "mru1_stale");
  EXPECT_EQ(log.entries()[0].t, at(30));
  EXPECT_FALSE(log.entries()[0].caused);
}

TEST(FaultLog, PairsALatchWithTheNewestCause) {
  FaultLog log;
  log.caused(at(10), "mru2:silent");
  log.caused(at(30), "mru1:silent");
  log.take(mode(ModeState::fault, 30.02, "mru1_stale"));
  ASSERT_EQ(log.entries().size(), 2u);
  EXPECT_FALSE(log.entries()[0].latched);
  EXPECT_EQ(log.entries()[1].latched, at(30.02));
  EXPECT_EQ(log.entries()[1].code, "mru1_stale");
}

TEST(FaultLog, DoesNotPairALatchWithALaterCause) {
  FaultLog log;
  log.caused(at(40), "arm:silent");
  log.take(mode(ModeState::fault, 30, "mru1_stale"));
  ASSERT_EQ(log.entries().size(), 2u);
  EXPECT_FALSE(log.entries()[0].latched);
}

TEST(FaultLog, CountsALatchOnceHoweverOftenItIsPublished) {
  FaultLog log;
  for (int i = 0; i < 3; ++i) log.take(mode(ModeState::fault, 30, "mru1_stale"));
  log.take(mode(ModeState::settled, 35));
  log.take(mode(ModeState::fault, 40, "arm_stale"));
  EXPECT_EQ(log.entries().size(), 2u);
}

TEST(FaultLog, IsAtRestWithTheFirstCommandAfterTheLatchThatMovesNothing) {
  FaultLog log;
  log.take(control(29, 0));
  log.take(mode(ModeState::fault, 30, "mru1_stale"));
  log.take(control(29.999, 0));  // decided before the latch
  log.take(control(30.1, 0.2));
  topic::Control winch_moves = control(30.2, 0);
  winch_moves.wire_speed_command_mps = -0.01;
  log.take(winch_moves);
  EXPECT_FALSE(log.entries()[0].at_rest);
  log.take(control(30.3, 0));
  log.take(control(30.4, 0));
  EXPECT_EQ(log.entries()[0].at_rest, at(30.3));
}

TEST(FaultLog, TakesARobotThatDoesNotFollowForOneThatRests) {
  FaultLog log;
  log.take(mode(ModeState::fault, 30, "mru1_stale"));
  topic::Control let_go = control(30.5, 0.1);
  let_go.following = false;
  log.take(let_go);
  EXPECT_EQ(log.entries()[0].at_rest, at(30.5));
}

TEST(FaultLog, IsBounded) {
  FaultLog log;
  for (int i = 0; i < 3000; ++i) log.take(mode(ModeState::fault, i, "mru1_stale"));
  for (int i = 0; i < 3000; ++i) log.caused(at(i), "again");
  EXPECT_EQ(log.entries().size(), FaultLog::kMost);
}

}  // namespace
}  // namespace motionlab::monitor
