#include "gateway/service/roll_call.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "drivers/core/error.hpp"
#include "tests/unit/service/configs.hpp"

namespace motionlab::service {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using topic::LinkState;

topic::Health health(const char* device, LinkState link, const char* advice = "") {
  topic::Health health;
  health.device = device;
  health.link = link;
  health.advice = advice;
  return health;
}

TEST(RollCall, WaitsForEveryRequiredDeviceAndSaysWhy) {
  const auto roll = call_roll(lab_config(), {health("mru1", LinkState::up), health("qualisys", LinkState::up),
                                             health("arm", LinkState::connecting, "Start its program."),
                                             health("mru2", LinkState::down)});
  EXPECT_FALSE(roll.complete());
  EXPECT_EQ(roll.waited_for(), "arm, winch");
  EXPECT_EQ(roll.sentence({}),
            "waiting for arm (connecting: Start its program.), winch (not looked at yet); up: mru1 qualisys; "
            "missing: mru2 (down)");
}

TEST(RollCall, IsCompleteWithoutDevicesThatAreNotRequired) {
  const auto roll =
      call_roll(lab_config(), {health("mru1", LinkState::up), health("arm", LinkState::up),
                               health("winch", LinkState::up), health("qualisys", LinkState::up)});
  EXPECT_TRUE(roll.complete());
  topic::Mode mode;
  mode.state = topic::ModeState::settled;
  mode.fault_code = "load_lost";
  mode.reason = "the cameras do not see the load";
  EXPECT_THAT(roll.sentence(mode), HasSubstr("settled load_lost: the cameras do not see the load; up: mru1"));
  EXPECT_THAT(roll.sentence(mode), HasSubstr("missing: mru2"));
}

TEST(RollCall, CallsALateDeviceConnected) {
  const auto roll =
      call_roll(lab_config(), {health("mru1", LinkState::stale), health("arm", LinkState::up),
                               health("winch", LinkState::up), health("qualisys", LinkState::up)});
  EXPECT_TRUE(roll.complete());
  EXPECT_THAT(roll.sentence({}), HasSubstr("mru1 (stale)"));
}

TEST(RollCall, DoesNotWaitForADeviceThatIsDeclaredAbsent) {
  const auto config = lab_config("[service]\nabsent = [\"arm\", \"mru2\"]\n");
  const auto roll = call_roll(
      config, {health("mru1", LinkState::up), health("arm", LinkState::down), health("winch", LinkState::up),
               health("qualisys", LinkState::up), health("mru2", LinkState::up)});
  EXPECT_TRUE(roll.complete());
  EXPECT_THAT(roll.absent, ElementsAre("arm"));  // mru2 has come after all
  EXPECT_THAT(roll.sentence({}), HasSubstr("up: mru1 mru2 qualisys winch"));
  EXPECT_THAT(roll.sentence({}), HasSubstr("declared absent: arm"));
}

TEST(RollCall, NamesThePlcsRemoteReplyWhereItIsAskedForAndNeverWaitsForIt) {
  const auto up = {health("mru1", LinkState::up), health("mru2", LinkState::up),
                   health("qualisys", LinkState::up), health("arm", LinkState::up),
                   health("winch", LinkState::up)};
  EXPECT_TRUE(call_roll(lab_config(), up).missing.empty());
  const auto config = lab_config("[plc_reply]\nenabled = true\n");
  const auto roll = call_roll(config, up);
  EXPECT_TRUE(roll.complete());
  EXPECT_THAT(roll.sentence({}), HasSubstr("missing: plc (not looked at yet)"));
  EXPECT_THAT(device_names(config), ElementsAre("mru1", "mru2", "qualisys", "arm", "winch", "plc"));
}

TEST(RollCall, KnowsNoOtherDeviceToBeAbsent) {
  try {
    (void)lab_config("[service]\nabsent = [\"crane\"]\n");
    FAIL();
  } catch (const StartupError& error) {
    EXPECT_THAT(error.what(), HasSubstr("[service] absent"));
    EXPECT_THAT(error.what(), HasSubstr("mru1, mru2, qualisys, arm, winch"));
  }
}

}  // namespace
}  // namespace motionlab::service
