#include "gateway/bus/flood_gate.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <vector>

#include "drivers/core/random.hpp"

namespace motionlab::bus {
namespace {

using topic::ModeAction;
using Time = GateWindow::Time;

constexpr Time kBegin{std::chrono::hours{1}};

topic::ModeRequest request(std::string_view requester, ModeAction action, std::uint64_t number = 0) {
  topic::ModeRequest sample;
  sample.requester = requester;
  sample.action = action;
  sample.sequence_number = number;
  return sample;
}

topic::Reference reference(std::string_view requester, std::uint64_t number) {
  topic::Reference sample;
  sample.requester = requester;
  sample.sequence_number = number;
  return sample;
}

TEST(RequestGate, PassesABurstOfTwoRequestersWhole) {
  RequestGate dut;
  for (const char* const who : {"a", "b"}) {
    for (std::size_t i = 0; i < RequestGate::kForOne; ++i) {
      EXPECT_TRUE(dut.passes(request(who, ModeAction::engage), kBegin));
    }
  }
  EXPECT_EQ(dut.refused(), 0U);
  EXPECT_EQ(dut.due(), Time::max());
}

TEST(RequestGate, OneWhoShoutsDoesNotSilenceTheOthers) {
  RequestGate dut;
  std::size_t passed = 0;
  for (int i = 0; i < 1000; ++i) {
    for (const char* const who : {"a", "b", "c"})
      passed += dut.passes(request(who, ModeAction::engage), kBegin);
  }
  EXPECT_EQ(passed, RequestGate::kForAll);
  EXPECT_EQ(dut.refused(), 3000 - passed);
  EXPECT_TRUE(dut.passes(request("quiet", ModeAction::reset), kBegin));
  EXPECT_FALSE(dut.passes(request("quiet", ModeAction::reset), kBegin)) << "but he does not get two";
  EXPECT_TRUE(dut.passes(request("a", ModeAction::engage), kBegin + kGateWindow)) << "the next window is new";
}

TEST(RequestGate, ASettlePassesAtOnceWhateverWasSpent) {
  RequestGate dut;
  for (int i = 0; i < 10'000; ++i) (void)dut.passes(request(std::to_string(i), ModeAction::engage), kBegin);
  EXPECT_TRUE(dut.passes(request("10001", ModeAction::settle), kBegin));
}

TEST(RequestGate, SettlesBeyondTheirTurnsAreOneWhenTheWindowEnds) {
  RequestGate dut;
  for (std::uint64_t n = 1; n <= 100; ++n) {
    EXPECT_EQ(dut.passes(request("a", ModeAction::settle, n), kBegin), n <= RequestGate::kForOne) << n;
  }
  EXPECT_EQ(dut.due(), kBegin + kGateWindow);
  EXPECT_FALSE(dut.held(kBegin + kGateWindow - 1ns));
  const auto held = dut.held(kBegin + kGateWindow);
  ASSERT_TRUE(held);
  EXPECT_EQ(held->sequence_number, 100U);
  EXPECT_FALSE(dut.held(kBegin + kGateWindow));
  EXPECT_EQ(dut.due(), Time::max());
  EXPECT_EQ(dut.refused(), 100 - RequestGate::kForOne - 1);
}

TEST(RequestGate, AnEngageBetweenTwoSettlesIsSettledAtOnceAndNotLater) {
  RequestGate dut;
  for (std::size_t i = 0; i < RequestGate::kForOne; ++i) {
    EXPECT_TRUE(dut.passes(request("a", ModeAction::engage), kBegin));
  }
  EXPECT_TRUE(dut.passes(request("a", ModeAction::settle), kBegin)) << "though his turns are spent";
  EXPECT_FALSE(dut.passes(request("a", ModeAction::settle), kBegin)) << "the last one's work is done";
  EXPECT_TRUE(dut.passes(request("b", ModeAction::engage), kBegin));
  EXPECT_TRUE(dut.passes(request("a", ModeAction::settle), kBegin)) << "at once";
  EXPECT_FALSE(dut.passes(request("a", ModeAction::settle), kBegin));
  EXPECT_TRUE(dut.passes(request("b", ModeAction::engage), kBegin));
  EXPECT_FALSE(dut.held(kBegin + kGateWindow)) << "what was said before the engage does not undo it";
}

/// Whoever reads what passed is left where he would be left by all of it: settled by a last settle at the
/// latest one window later, and never handed more than a window's worth.
TEST(RequestGate, WhateverComesALastSettleIsTheLastWordAndTheStepIsSpared) {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    Random random(seed);
    RequestGate dut;
    Time now = kBegin;
    std::vector<std::pair<Time, topic::ModeRequest>> passed;
    const auto take_held = [&] {
      while (const auto held = dut.held(now)) passed.emplace_back(now, *held);
    };
    for (std::uint64_t n = 1; n <= 3000; ++n) {
      now += std::chrono::microseconds{random.below(200)};
      take_held();
      const auto action = random.chance(0.2) ? ModeAction::settle : ModeAction::engage;
      const auto sample = request(std::to_string(random.below(100)), action, n);
      if (dut.passes(sample, now)) passed.emplace_back(now, sample);
    }
    const auto last = request("last", ModeAction::settle, 5000);
    if (dut.passes(last, now)) passed.emplace_back(now, last);
    now += kGateWindow;
    take_held();
    ASSERT_FALSE(passed.empty());
    EXPECT_EQ(passed.back().second.action, ModeAction::settle) << seed;
    EXPECT_EQ(passed.back().second.sequence_number, 5000U) << seed;
    for (std::size_t i = 1; i < passed.size(); ++i) {
      EXPECT_GT(passed[i].second.sequence_number, passed[i - 1].second.sequence_number) << seed;
    }
    constexpr std::size_t kMost = 2 * (RequestGate::kForAll + RequestGate::kForNewcomers) + 1;
    for (std::size_t i = 2 * kMost; i < passed.size(); ++i) {  // any time of one window's length touches two
      EXPECT_GE(passed[i].first - passed[i - 2 * kMost].first, kGateWindow) << seed;
    }
  }
}

TEST(ReferenceGate, PassesTheFirstAtOnceAndTheNewestWhenTheWindowEnds) {
  ReferenceGate dut;
  EXPECT_TRUE(dut.passes(reference("a", 1), kBegin));
  for (std::uint64_t n = 2; n <= 100; ++n) {
    EXPECT_FALSE(dut.passes(reference(n % 2 ? "a" : "b", n), kBegin + 1ms));
  }
  EXPECT_EQ(dut.due(), kBegin + kGateWindow);
  EXPECT_FALSE(dut.held(kBegin + 9ms));
  EXPECT_EQ(dut.held(kBegin + kGateWindow)->sequence_number, 100U);
  EXPECT_FALSE(dut.held(kBegin + kGateWindow));
  EXPECT_FALSE(dut.passes(reference("a", 101), kBegin + kGateWindow)) << "the held one was this window's";
  EXPECT_EQ(dut.held(kBegin + 2 * kGateWindow)->sequence_number, 101U);
  EXPECT_EQ(dut.refused(), 98U);
}

TEST(ReferenceGate, DoesNotDelayOneWhoTellsAMovingPlace) {
  ReferenceGate dut;
  for (int i = 0; i < 100; ++i) EXPECT_TRUE(dut.passes(reference("a", 1), kBegin + i * kGateWindow));
  EXPECT_EQ(dut.refused(), 0U);
}

}  // namespace
}  // namespace motionlab::bus
