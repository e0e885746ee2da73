#include "gateway/service/live_settings.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/service/configs.hpp"

namespace motionlab::service {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using topic::ModeState;

std::vector<std::string> keys(const std::vector<LiveSettings::Change>& changes) {
  std::vector<std::string> names;
  for (const auto& change : changes) names.push_back((change.refused.empty() ? "+" : "-") + change.key);
  return names;
}

TEST(LiveSettings, FindNothingInAnUnchangedFile) {
  LiveSettings settings(lab_config());
  EXPECT_THAT(settings.take(lab_config(), ModeState::engaged), IsEmpty());
}

TEST(LiveSettings, TakeWhatMovesNothingAtAnyTime) {
  LiveSettings settings(lab_config());
  const auto read = lab_config("[service]\nabsent = [\"mru2\"]\nlog_level = \"error\"\n");
  EXPECT_THAT(keys(settings.take(read, ModeState::engaged)),
              ElementsAre("+[service] absent", "+[service] log_level"));
  EXPECT_THAT(settings.in_force().absent, ElementsAre("mru2"));
  EXPECT_EQ(settings.in_force().log_level, LogLevel::error);
  EXPECT_THAT(settings.take(read, ModeState::engaged), IsEmpty());
}

TEST(LiveSettings, MoveTheLoadsPlaceOnlyWhileNothingIsEngaged) {
  LiveSettings settings(lab_config());
  const auto read = lab_config("[reference]\np_world_load_m = [0.8, -0.4, 3.9]\n");
  for (const auto mode : {ModeState::engaged, ModeState::stopping}) {
    const auto changes = settings.take(read, mode);
    ASSERT_THAT(keys(changes), ElementsAre("-[reference] p_world_load_m"));
    EXPECT_THAT(changes.front().refused, HasSubstr("settle"));
    EXPECT_EQ(settings.in_force().p_world_load_reference_m, lab_config().p_world_load_reference_m);
  }
  // What was refused is asked for again.
  EXPECT_THAT(keys(settings.take(read, ModeState::settled)), ElementsAre("+[reference] p_world_load_m"));
  EXPECT_EQ(settings.in_force().p_world_load_reference_m, read.p_world_load_reference_m);
}

TEST(LiveSettings, RefuseEverythingElseByName) {
  LiveSettings settings(lab_config());
  const auto read = lab_config(
      "[limits]\nwire_speed_max_mps = 0.1\n[mru1]\nstale_after_s = 0.1\n[service]\nlog_level = "
      "\"error\"\n");
  const auto changes = settings.take(read, ModeState::settled);
  EXPECT_THAT(keys(changes),
              ElementsAre("-[limits] wire_speed_max_mps", "-[mru1] stale_after_s", "+[service] log_level"));
  EXPECT_THAT(changes.front().refused, HasSubstr("restart"));
  EXPECT_DOUBLE_EQ(settings.in_force().limits.wire_speed_max_mps, lab_config().limits.wire_speed_max_mps);
}

TEST(LiveSettings, SeeIntoInlineTables) {
  LiveSettings settings(lab_config());
  const auto read = lab_config("[calibration]\nworld_to_qtm = { p_m = [0.7, -0.7793, 1.4229] }\n");
  EXPECT_THAT(keys(settings.take(read, ModeState::settled)), ElementsAre("-[calibration] world_to_qtm"));
}

}  // namespace
}  // namespace motionlab::service
