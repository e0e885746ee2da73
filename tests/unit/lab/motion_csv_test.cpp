#include "simulators/lab/motion_csv.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>
#include <sstream>

#include "drivers/core/error.hpp"
#include "simulators/lab/lab_config.hpp"

namespace motionlab::lab {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

constexpr const char* kHeader = "t_s,surge_m,sway_m,heave_m,roll_deg,pitch_deg,yaw_deg\n";

plant::RecordedMotion read(const std::string& text) {
  std::istringstream in(text);
  return read_motion_csv(in, "motion.csv");
}

std::string error_of(const std::string& text) {
  try {
    (void)read(text);
  } catch (const StartupError& error) {
    return error.what();
  }
  return "no error";
}

const std::string kRows = "0,0,0,0,0,0,0\n1,0.1,0.2,0.3,1,2,3\n2,0,0,0,0,0,0\n3,0,0,0,0,0,0\n";

TEST(MotionCsv, ReadsMetresAndDegrees) {
  const auto s = read(kHeader + kRows).at(1);
  const double degree = std::numbers::pi / 180;
  plant::Vector6d eta;
  eta << 0.1, 0.2, 0.3, 1 * degree, 2 * degree, 3 * degree;
  EXPECT_LT((s.eta - eta).norm(), 1e-15);
}

TEST(MotionCsv, TakesColumnsInAnyOrderBlanksCommentsAndCarriageReturns) {
  const auto motion = read(
      "\xef\xbb\xbf# a recording\r\n heave_m , t_s,surge_m,sway_m,roll_deg,pitch_deg,yaw_deg\r\n\r\n"
      "0,10,0,0,0,0,0\r\n0.3 , 11,0,0,0,0,0\r\n0,12,0,0,0,0,0\r\n0,13,0,0,0,0,0\r\n");
  EXPECT_NEAR(motion.at(1).eta[2], 0.3, 1e-15);
  EXPECT_EQ(motion.duration_s(), 3);
}

TEST(MotionCsv, SaysWhereItIsWrongAndWhatToWrite) {
  EXPECT_THAT(error_of("time,heave\n1,2\n"), StartsWith("motion.csv:1: the header"));
  EXPECT_THAT(error_of("time,heave\n1,2\n"), HasSubstr("t_s,surge_m"));
  EXPECT_THAT(error_of(std::string(kHeader) + "0,0,0,0,0,0,0\n1,0,0,0,0,0\n"),
              StartsWith("motion.csv:3: 6 values"));
  EXPECT_THAT(error_of(std::string(kHeader) + "0,0,0,0,0,0,0\n1,0,0,x,0,0,0\n"),
              StartsWith("motion.csv:3: heave_m: \"x\" is not a number"));
  EXPECT_THAT(error_of(std::string(kHeader) + "0,0,0,nan,0,0,0\n"), HasSubstr("motion.csv:2: heave_m"));
  EXPECT_THAT(error_of(std::string(kHeader) + "1,0,0,0,0,0,0\n1,0,0,0,0,0,0\n"),
              StartsWith("motion.csv:3: t_s does not increase"));
  EXPECT_THAT(error_of(std::string(kHeader) + "1,0,0,0,0,0,0\n"), HasSubstr("at least 4"));
  EXPECT_THAT(error_of(""), HasSubstr("empty"));
  EXPECT_THROW((void)read_motion_csv(std::filesystem::path("/nowhere.csv")), StartupError);
}

std::string refusal(const LabConfig& config, const plant::PlatformLimits& limits) {
  try {
    config.refuse_beyond(limits, 120);
  } catch (const StartupError& error) {
    return error.what();
  }
  return "no error";
}

TEST(LabConfig, RefusesASeaBeyondThePlatformAndSaysWhatFits) {
  LabConfig config;
  config.set_scenario("sea");
  EXPECT_EQ(refusal(config, plant::PlatformLimits::mechanical()), "no error");
  EXPECT_THAT(refusal(config, plant::PlatformLimits::plc()), HasSubstr("the PLC's limit is"));
  config.sea.significant_height_m = 1.0;
  config.set_scenario("sea");
  const std::string text = refusal(config, plant::PlatformLimits::mechanical());
  EXPECT_THAT(text, HasSubstr("heave: "));
  // What it advises is true to its last digit.
  constexpr std::string_view kAdvice = "the largest Hs that fits is ";
  ASSERT_THAT(text, HasSubstr(std::string(kAdvice)));
  const double advised = std::stod(text.substr(text.find(kAdvice) + kAdvice.size()));
  config.sea.significant_height_m = advised;
  config.set_scenario("sea");
  EXPECT_EQ(refusal(config, plant::PlatformLimits::mechanical()), "no error");
  config.sea.significant_height_m = advised + 0.001;
  config.set_scenario("sea");
  EXPECT_NE(refusal(config, plant::PlatformLimits::mechanical()), "no error");
}

TEST(LabConfig, ReadsTheSeaFromTheFile) {
  const LabConfig plain = LabConfig::load(MOTIONLAB_SOURCE_DIR "/deploy/config/world.toml");
  EXPECT_FALSE(plain.sea.significant_height_m);
  EXPECT_FALSE(plain.sea.direction);
  LabConfig c =
      LabConfig::load(MOTIONLAB_SOURCE_DIR "/deploy/config/world.toml", {},
                      {{"test", "sea = { directional = true, mean_direction_deg = 90, peak_period_s = 9 }"}});
  c.set_scenario("sea");
  ASSERT_TRUE(c.scenario.direction);
  EXPECT_NEAR(c.scenario.direction->mean_rad, std::numbers::pi / 2, 1e-12);
  EXPECT_EQ(c.scenario.peak_period_s, 9);
  EXPECT_EQ(c.scenario.significant_height_m, 0.5);
}

}  // namespace
}  // namespace motionlab::lab
