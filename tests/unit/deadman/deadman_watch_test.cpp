// Which silence is held against the gateway, on a virtual clock.
#include "gateway/deadman/deadman_watch.hpp"

#include <gtest/gtest.h>

namespace motionlab::deadman {
namespace {

constexpr DeadmanWatch::Config kLab{
    .look_period = 2ms, .io_silent_after = 20ms, .control_silent_after = 200ms};

/// A gateway that beats at each look, unless a thread of it stands still.
class Gateway {
 public:
  Verdict look_after(Nanoseconds passed) {
    now_ += passed;
    if (io_beats) ++sight.io_beats;
    if (control_beats) ++sight.control_beats;
    return watch_.look(now_, sight);
  }
  /// Looks in time until the verdict is another than alive. @returns how long it took
  Nanoseconds until_accused() {
    const LabTime begun = now_;
    while (verdict == Verdict::alive && now_ - begun < 10s) verdict = look_after(kLab.look_period);
    return now_ - begun;
  }

  Sight sight;
  bool io_beats = true;
  bool control_beats = true;
  Verdict verdict = Verdict::alive;

 private:
  DeadmanWatch watch_{kLab};
  LabTime now_{};
};

TEST(DeadmanWatch, LeavesAGatewayAloneThatBeats) {
  Gateway gateway;
  for (int i = 0; i < 10'000; ++i) ASSERT_EQ(gateway.look_after(2ms), Verdict::alive);
}

TEST(DeadmanWatch, AccusesASilentIoThreadAfterItsTime) {
  Gateway gateway;
  (void)gateway.look_after(2ms);
  gateway.io_beats = false;
  EXPECT_EQ(gateway.until_accused(), 20ms);
  EXPECT_EQ(gateway.verdict, Verdict::io_silent);
}

TEST(DeadmanWatch, AccusesASilentControlThreadAfterItsOwnTime) {
  Gateway gateway;
  (void)gateway.look_after(2ms);
  gateway.control_beats = false;
  EXPECT_EQ(gateway.until_accused(), 200ms);
  EXPECT_EQ(gateway.verdict, Verdict::control_silent);
}

TEST(DeadmanWatch, CountsAnewAfterEachBeat) {
  Gateway gateway;
  for (int i = 0; i < 1000; ++i) {
    gateway.io_beats = i % 9 == 0;  // a beat each 18 ms
    ASSERT_EQ(gateway.look_after(2ms), Verdict::alive);
  }
}

TEST(DeadmanWatch, AccusesNobodyWhoseMachineStoodStill) {
  Gateway gateway;
  (void)gateway.look_after(2ms);
  gateway.io_beats = gateway.control_beats = false;
  for (int i = 0; i < 9; ++i) ASSERT_EQ(gateway.look_after(500ms), Verdict::alive);
  gateway.io_beats = gateway.control_beats = true;
  EXPECT_EQ(gateway.look_after(500ms), Verdict::alive);
}

TEST(DeadmanWatch, StillAccusesWhenEachOfItsOwnLooksIsLate) {
  Gateway gateway;
  (void)gateway.look_after(2ms);
  gateway.io_beats = false;
  int looks = 0;
  while (gateway.look_after(7ms) == Verdict::alive) ASSERT_LT(++looks, 11);
}

TEST(DeadmanWatch, WaitsForTheFirstBeat) {
  Gateway gateway;
  gateway.io_beats = gateway.control_beats = false;
  EXPECT_EQ(gateway.until_accused(), 10s);
  EXPECT_EQ(gateway.verdict, Verdict::alive);
}

TEST(DeadmanWatch, SeesAtOnceThatTheGatewayIsGone) {
  Gateway gateway;
  (void)gateway.look_after(2ms);
  gateway.sight.gone = true;
  EXPECT_EQ(gateway.look_after(0ms), Verdict::gone);
}

TEST(DeadmanWatch, AsksNoBeatsOfAGatewayThatLeavesButSeesItsEnd) {
  Gateway gateway;
  (void)gateway.look_after(2ms);
  gateway.io_beats = gateway.control_beats = false;
  gateway.sight.phase = Phase::leaving;
  EXPECT_EQ(gateway.until_accused(), 10s);
  gateway.sight.gone = true;
  EXPECT_EQ(gateway.look_after(2ms), Verdict::gone);
}

TEST(DeadmanWatch, IsNotNeededAfterAnOrderlyEndEvenIfTheGatewayIsGoneByThen) {
  Gateway gateway;
  (void)gateway.look_after(2ms);
  gateway.sight.phase = Phase::ended;
  gateway.sight.gone = true;
  EXPECT_EQ(gateway.look_after(2ms), Verdict::ended);
}

}  // namespace
}  // namespace motionlab::deadman
