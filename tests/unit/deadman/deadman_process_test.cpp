// The process itself, without a laboratory: when it goes, and what it ignores.
#include <gtest/gtest.h>
#include <poll.h>
#include <signal.h>

#include "drivers/core/error.hpp"
#include "gateway/deadman/deadman.hpp"

namespace motionlab::deadman {
namespace {

/// Whether that process ends within the patience of a loaded machine.
bool ends(int pidfd, int milliseconds = 20'000) {
  pollfd gone{pidfd, POLLIN, 0};
  return ::poll(&gone, 1, milliseconds) == 1;
}

std::unique_ptr<Lifeline> fork_one() {
  Config patient;  // a loaded machine may keep this test from beating
  patient.io_silent_after = patient.control_silent_after = 600s;
  return fork_deadman(patient, [](const std::string&) {});
}

TEST(DeadmanProcess, EndsWhenTheGatewayEndsInOrder) {
  const auto lifeline = fork_one();
  EXPECT_FALSE(ends(lifeline->deadman_pidfd(), 50));
  lifeline->end_in_order();
  EXPECT_TRUE(ends(lifeline->deadman_pidfd()));
}

TEST(DeadmanProcess, IsSeenToLookWhileTheGatewayBeats) {
  const auto lifeline = fork_one();
  for (int i = 0; i < 2000; ++i) {
    lifeline->io_beat();
    lifeline->control_beat();
    ::poll(nullptr, 0, 1);
    ASSERT_FALSE(lifeline->deadman_silent());
  }
}

TEST(DeadmanProcess, IsMissedAfterAThousandBeatsWithoutALook) {
  // A page that nobody looks at, and files that are none.
  Page page;
  page.phase = Phase::ended;
  Lifeline lifeline(page, File(), File());
  for (int i = 0; i < 1000; ++i) lifeline.io_beat();
  EXPECT_FALSE(lifeline.deadman_silent());
  lifeline.io_beat();
  EXPECT_TRUE(lifeline.deadman_silent());
  ++page.deadman_ticks;
  lifeline.io_beat();
  EXPECT_FALSE(lifeline.deadman_silent());
}

TEST(DeadmanProcess, IsToldWhatReallyLeft) {
  Page page;
  Lifeline lifeline(page, File(), File());
  EXPECT_FALSE(page.sent.read());
  lifeline.sent(true, {0.1, 0.2, 0.3, 0.4, 0.5, 0.6});
  const auto last = page.sent.read();
  ASSERT_TRUE(last);
  EXPECT_EQ(last->value.command.mode, 1);
  EXPECT_EQ(last->value.command.qd_radps, (std::array<float, 6>{0.1F, 0.2F, 0.3F, 0.4F, 0.5F, 0.6F}));
  EXPECT_GT(last->value.t_monotonic_ns, 0);
}

}  // namespace
}  // namespace motionlab::deadman
