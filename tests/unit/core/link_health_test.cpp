#include "drivers/core/link_health.hpp"

#include <gtest/gtest.h>

namespace motionlab {
namespace {

TEST(LinkHealth, KnowsNothingBeforeTheFirstSample) {
  const LinkHealth health;
  EXPECT_EQ(health.phase(), LinkPhase::down);
  EXPECT_FALSE(health.t_measured());
  EXPECT_FALSE(health.t_received());
  EXPECT_FALSE(health.last_fault());
  EXPECT_TRUE(health.advice().empty());
  EXPECT_EQ(health.rate_hz(LabTime{1s}), 0.0);
  EXPECT_EQ(health.received(), 0u);
  EXPECT_EQ(health.rejected_total(), 0u);
}

TEST(LinkHealth, CountsSamplesAndTheirRate) {
  LinkHealth health;
  LabTime t{100s};
  for (; t < LabTime{103s}; t += 5ms) health.accepted(t - 2ms, t);
  EXPECT_EQ(health.received(), 600u);
  EXPECT_NEAR(health.rate_hz(t), 200.0, 1e-9);
  EXPECT_EQ(health.t_received(), t - 5ms);
  EXPECT_EQ(health.t_measured(), t - 7ms);
  EXPECT_EQ(health.age_max(), 7ms);
}

TEST(LinkHealth, TheRateOfASilentLinkIsZero) {
  LinkHealth health;
  LabTime t{100s};
  for (; t < LabTime{103s}; t += 5ms) health.accepted(t, t);
  EXPECT_GT(health.rate_hz(t + 1400ms), 0.0);
  EXPECT_EQ(health.rate_hz(t + 1500ms), 0.0);
}

TEST(LinkHealth, TheGreatestAgeIsThatOfASampleWhenItsSuccessorCame) {
  LinkHealth health;
  health.accepted(LabTime{100s}, LabTime{100s + 1ms});
  EXPECT_EQ(health.age_max(), 0ns);
  health.accepted(LabTime{100s + 50ms}, LabTime{100s + 51ms});
  health.accepted(LabTime{100s + 55ms}, LabTime{100s + 56ms});
  EXPECT_EQ(health.age_max(), 51ms);
}

TEST(LinkHealth, CountsEveryReasonByItself) {
  LinkHealth health;
  for (std::size_t i = 0; i < kReasonCount; ++i) {
    for (std::size_t n = 0; n <= i; ++n) health.rejected({static_cast<Reason>(i), "why"});
  }
  for (std::size_t i = 0; i < kReasonCount; ++i) EXPECT_EQ(health.rejected(static_cast<Reason>(i)), i + 1);
  EXPECT_EQ(health.rejected_total(), kReasonCount * (kReasonCount + 1) / 2);
  ASSERT_TRUE(health.last_fault());
  EXPECT_EQ(health.last_fault()->reason, Reason::transport);
  EXPECT_EQ(health.last_fault()->text, "why");
}

TEST(LinkHealth, CountsLossesAndReconnectsAndKeepsPhaseAndAdvice) {
  LinkHealth health;
  health.lost(3);
  health.lost(4);
  health.reconnected();
  health.phase(LinkPhase::up);
  health.advice("plug it in");
  EXPECT_EQ(health.lost(), 7u);
  EXPECT_EQ(health.reconnects(), 1u);
  EXPECT_EQ(health.phase(), LinkPhase::up);
  EXPECT_EQ(health.advice(), "plug it in");
}

}  // namespace
}  // namespace motionlab
