#include "simulators/lab/settings.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "drivers/core/error.hpp"
#include "simulators/lab/lab_config.hpp"

namespace motionlab::lab {
namespace {

using testing::HasSubstr;

const std::filesystem::path kShipped = MOTIONLAB_SOURCE_DIR "/deploy/config/world.toml";

LabConfig with(const std::vector<std::string>& texts) {
  return LabConfig::load(kShipped, {}, Settings::parse(texts).world);
}

std::string error_of(const std::vector<std::string>& texts) {
  try {
    (void)with(texts);
  } catch (const StartupError& error) {
    return error.what();
  }
  return "no error";
}

TEST(Settings, LayValuesOfEveryKindOverTheFile) {
  const LabConfig c =
      with({"world.load.mass_kg=36", "world.arm.flexible=false", "world.devices.mru1.checksum=sum8",
            "world.mru1.acceleration_bias_mps2=[0, 0, 0]", "world.devices.arm.listen=127.0.0.1:6"});
  EXPECT_EQ(c.world.load.mass_kg, 36);
  EXPECT_FALSE(c.world.arm_mode.flexible);
  EXPECT_EQ(c.mru1.device.checksum_rule,
            with({"world.devices.mru1.checksum=\"sum8\""}).mru1.device.checksum_rule);
  EXPECT_EQ(c.world.mru1.acceleration_bias_mps2.norm(), 0);
  EXPECT_EQ(c.arm_listen.port, 6);
  EXPECT_EQ(c.world.load.wire_ea_n, 2e5) << "the rest stays";
}

TEST(Settings, TheLastOfTwoCounts) {
  EXPECT_EQ(with({"world.load.mass_kg=36", "world.load.mass_kg=6"}).world.load.mass_kg, 6);
}

TEST(Settings, GoToTheFileTheyName) {
  const Settings s = Settings::parse({"lab.arm.servo_omega_radps=30", "world.load.mass_kg=6"});
  ASSERT_EQ(s.lab.size(), 1U);
  ASSERT_EQ(s.world.size(), 1U);
  EXPECT_EQ(s.lab[0].text, "arm.servo_omega_radps = 30");
}

TEST(Settings, AreCheckedLikeTheFile) {
  EXPECT_THAT(error_of({"world.load.mass_kilo=3"}), HasSubstr("did you mean mass_kg"));
  EXPECT_THAT(error_of({"world.load.mass_kilo=3"}), HasSubstr("--set world.load.mass_kilo=3:1:"));
  EXPECT_THAT(error_of({"world.load.mass_kg=-3"}), HasSubstr("out of range"));
  EXPECT_THAT(error_of({"world.load.mass_kg=heavy"}), HasSubstr("a text stands where"));
  EXPECT_THAT(error_of({"world.load.mass_kg=["}), HasSubstr("correct this text"));
}

TEST(Settings, RefuseWhatIsNotOneAndShowTheForm) {
  for (const char* text : {"mass_kg", "mass_kg=3", "moon.load.mass_kg=3", "world.=3", "=3"}) {
    EXPECT_THAT(error_of({text}), HasSubstr("write world.TABLE.KEY=VALUE")) << text;
  }
}

}  // namespace
}  // namespace motionlab::lab
