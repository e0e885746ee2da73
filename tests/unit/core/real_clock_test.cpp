#include "drivers/core/real_clock.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <thread>

namespace motionlab {
namespace {

TEST(SlewedOffset, WalksAtFiveHundredPpmAndThenStays) {
  const SlewedOffset walk{.start = 100s, .offset = 1000s, .slew = 1ms};
  EXPECT_EQ(walk.at(100s), LabTime{1100s});
  EXPECT_EQ(walk.at(101s), LabTime{1101s + 500us});
  EXPECT_EQ(walk.at(102s), LabTime{1102s + 1ms});
  EXPECT_EQ(walk.at(200s), LabTime{1200s + 1ms});
  const SlewedOffset back{.start = 100s, .offset = 1000s, .slew = -1ms};
  EXPECT_EQ(back.at(101s), LabTime{1101s - 500us});
  EXPECT_EQ(back.at(200s), LabTime{1200s - 1ms});
}

TEST(SlewedOffset, TheNextWalkBeginsWhereThisOneIs) {
  const SlewedOffset walk{.start = 100s, .offset = 1000s, .slew = 10s};
  const SlewedOffset next = walk.next(101s, 1000s);
  EXPECT_EQ(next.at(101s), walk.at(101s));
  EXPECT_LT(next.at(102s), LabTime{1102s + 500us});
}

TEST(SlewedOffset, FollowsAUtcThatStepsWithoutEverSteppingItself) {
  SlewedOffset walk{.start = 0s, .offset = 0s, .slew = 0s};
  LabTime last{};
  for (Nanoseconds t = 0s; t < 100s; t += 10ms) {
    const LabTime now = walk.at(t);
    EXPECT_GE(now - last, t == 0s ? 0ns : Nanoseconds{10ms} - 5us);
    EXPECT_LE(now - last, Nanoseconds{10ms} + 5us);
    last = now;
    if (t % 1s == 0s) walk = walk.next(t, t + (t < 10s ? 0ms : 20ms));
  }
  EXPECT_EQ(last, LabTime{100s - 10ms + 20ms});
}

TEST(RealClock, StartsAtUtc) {
  const RealClock clock;
  const auto utc =
      std::chrono::duration_cast<Nanoseconds>(std::chrono::system_clock::now().time_since_epoch());
  EXPECT_LT(std::abs(seconds(clock.now().time_since_epoch() - utc)), 1.0);
}

TEST(RealClock, NeverGoesBackInAnyThreadWhileItIsDisciplined) {
  RealClock clock;
  std::atomic<bool> stop{false};
  std::atomic<int> failures{0};
  std::thread reader([&] {
    LabTime last{};
    while (!stop) {
      const LabTime now = clock.now();
      failures += now < last;
      last = now;
    }
  });
  LabTime last{};
  for (int i = 0; i < 20000; ++i) {
    clock.discipline();
    const LabTime now = clock.now();
    failures += now < last;
    last = now;
  }
  stop = true;
  reader.join();
  EXPECT_EQ(failures, 0);
  EXPECT_LT(clock.error(), 1s);
  EXPECT_GT(clock.error(), -1s);
}

}  // namespace
}  // namespace motionlab
