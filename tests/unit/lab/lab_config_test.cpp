#include "simulators/lab/lab_config.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "drivers/core/error.hpp"

namespace motionlab::lab {
namespace {

using testing::HasSubstr;

const std::filesystem::path kShipped = MOTIONLAB_SOURCE_DIR "/deploy/config/world.toml";

class LabConfigFile : public testing::Test {
 protected:
  ~LabConfigFile() override { std::filesystem::remove(file_); }

  LabConfig load(const std::string& text) {
    std::ofstream(file_) << text;
    return LabConfig::load(file_);
  }
  std::string error_of(const std::string& text) {
    try {
      (void)load(text);
    } catch (const StartupError& error) {
      return error.what();
    }
    return "no error";
  }

  std::filesystem::path file_ =
      std::filesystem::temp_directory_path() / ("lab_config_test_" + std::to_string(getpid()) + ".toml");
};

TEST(LabConfig, TheShippedFileSaysWhatTheDefaultsSay) {
  const LabConfig file = LabConfig::load(kShipped), code;
  EXPECT_EQ(file.world.differences.joint_bandwidth_factor, code.world.differences.joint_bandwidth_factor);
  EXPECT_NEAR(file.world.differences.calibration_angle_rad, code.world.differences.calibration_angle_rad,
              1e-9);
  EXPECT_EQ(file.world.differences.sensor_extra_latency_s, code.world.differences.sensor_extra_latency_s);
  EXPECT_EQ(file.world.differences.wire_extra_m, code.world.differences.wire_extra_m);
  EXPECT_EQ(file.world.calibration.world_to_em8000.p, code.world.calibration.world_to_em8000.p);
  EXPECT_EQ(file.world.calibration.world_to_qtm.R, code.world.calibration.world_to_qtm.R);
  EXPECT_EQ(file.world.arm.omega_radps, code.world.arm.omega_radps);
  for (std::size_t j = 0; j < 6; ++j) {
    EXPECT_NEAR(file.world.arm.stroke_min_rad[j], code.world.arm.stroke_min_rad[j], 1e-6);
    EXPECT_NEAR(file.world.arm.stroke_max_rad[j], code.world.arm.stroke_max_rad[j], 1e-6);
    EXPECT_NEAR(file.world.arm.speed_max_radps[j], code.world.arm.speed_max_radps[j], 1e-6);
    EXPECT_NEAR(file.arm.q_min_rad[j], code.arm.q_min_rad[j], 1e-12);
  }
  EXPECT_NEAR(file.world.arm_geometry.reach_m, code.world.arm_geometry.reach_m, 1e-12);
  EXPECT_EQ(file.world.winch.omega_radps, 25.1327);
  EXPECT_EQ(file.world.load.mass_kg, code.world.load.mass_kg);
  EXPECT_EQ(file.world.load.wire_ea_n, code.world.load.wire_ea_n);
  for (const auto& [a, b] :
       {std::pair{file.world.mru1, code.world.mru1}, std::pair{file.world.mru2, code.world.mru2}}) {
    EXPECT_LT((a.misalignment_rad - b.misalignment_rad).norm(), 1e-12);
    EXPECT_EQ(a.lever_to_origin_m, b.lever_to_origin_m);
    EXPECT_NEAR(a.yaw_walk_rad_per_sqrt_s, b.yaw_walk_rad_per_sqrt_s, 1e-12);
    EXPECT_EQ(a.acceleration_bias_mps2, b.acceleration_bias_mps2);
    EXPECT_EQ(a.output_latency_s, b.output_latency_s);
  }
  EXPECT_EQ(file.world.camera.latency_s, code.world.camera.latency_s);
  EXPECT_NEAR(file.world.camera.angle_noise_rms_rad, code.world.camera.angle_noise_rms_rad, 1e-12);
  EXPECT_EQ(file.mru1.device.to, code.mru1.device.to);
  EXPECT_EQ(file.mru2.device.layout.token, 12);
  EXPECT_EQ(file.qualisys_listen, code.qualisys_listen);
  EXPECT_EQ(file.arm_listen, code.arm_listen);
  EXPECT_EQ(file.winch_listen, code.winch_listen);
  EXPECT_EQ(file.plc_reply_enabled, code.plc_reply_enabled);
  EXPECT_EQ(file.plc_reply_listen, code.plc_reply_listen);
  EXPECT_EQ(file.plc_reply.to, code.plc_reply.to);
  EXPECT_TRUE(file.arm.hardened);
  EXPECT_EQ(file.arm.peer, code.arm.peer);
  EXPECT_EQ(file.arm.long_answers, code.arm.long_answers);
  EXPECT_EQ(file.arm.acceleration_max_radps2, code.arm.acceleration_max_radps2);
  EXPECT_EQ(file.arm.pendant, code.arm.pendant);
}

TEST_F(LabConfigFile, AnEmptyFileIsTheDefaultLaboratory) {
  EXPECT_EQ(load("").world.load.mass_kg, 12.0);
}

TEST_F(LabConfigFile, SaysWhereAKeyIsUnknownAndWhatWasProbablyMeant) {
  const std::string error = error_of("[load]\nmass_g = 12000\n");
  EXPECT_THAT(error, HasSubstr(":2:"));
  EXPECT_THAT(error, HasSubstr("mass_kg"));
}

TEST_F(LabConfigFile, RefusesValuesOutOfRange) {
  EXPECT_THAT(error_of("[load]\nmass_kg = -1\n"), HasSubstr("[load] mass_kg"));
  EXPECT_THAT(error_of("[differences]\njoint_bandwidth_factor = 0\n"), HasSubstr("joint_bandwidth_factor"));
  EXPECT_THAT(error_of("[winch]\nstart_length_m = 9\n"), HasSubstr("start_length_m"));
  EXPECT_THAT(error_of("[load]\nwire_ea_n = 1e12\n"), HasSubstr("wire_ea_n"));
  EXPECT_THAT(error_of("[calibration]\nworld_to_qtm = { q = [1, 1, 0, 0], p_m = [0, 0, 0] }\n"),
              HasSubstr("unit length"));
  EXPECT_THAT(error_of("[devices.winch]\nnet_id = \"1.2.3\"\n"), HasSubstr("net_id"));
  EXPECT_THAT(error_of("[devices.mru1]\nto = \"somewhere\"\n"), HasSubstr("to"));
}

TEST_F(LabConfigFile, PlansFaultsForEveryRun) {
  const LabConfig c = load("[devices]\nfaults = [\"mru1:silent@12\", \"qualisys:loss=0.3@5..8\"]\n");
  ASSERT_EQ(c.faults.size(), 2U);
  EXPECT_EQ(c.faults[0].device, "mru1");
  EXPECT_EQ(c.faults[1].fault, "loss");
  EXPECT_EQ(c.faults[1].until_s, 8);
  EXPECT_THAT(error_of("[devices]\nfaults = [\"mru1\"]\n"), HasSubstr("mru1"));
}

TEST_F(LabConfigFile, SaysWhoMayCommandTheArm) {
  EXPECT_EQ(load("").arm.peer, Endpoint::parse("127.0.0.1:0"));
  EXPECT_EQ(load("[devices.arm]\npeer = \"192.168.90.42:50042\"\n").arm.peer,
            Endpoint::parse("192.168.90.42:50042"));
  EXPECT_THAT(error_of("[devices.arm]\npeer = \"the gateway\"\n"), HasSubstr("peer"));
}

TEST_F(LabConfigFile, LoadsTheWinchsProjectAndTheRoutesItKnows) {
  const LabConfig c = load("[devices.winch]\nproject = \"legacy\"\nroutes = [\"192.168.90.70.1.1\"]\n");
  EXPECT_EQ(c.winch.project, winch::PlcProject::legacy);
  ASSERT_EQ(c.winch.routes.size(), 1U);
  EXPECT_EQ(winch::to_string(c.winch.routes[0]), "192.168.90.70.1.1");
  EXPECT_THAT(error_of("[devices.winch]\nroutes = [\"192.168.90.70\"]\n"), HasSubstr("not an AMS NetId"));
  EXPECT_THAT(error_of("[devices.winch]\nproject = \"old\"\n"), HasSubstr("gvl_winch"));
}

TEST(LabConfig, RefusesAnUnknownScenarioAndListsThem) {
  LabConfig config;
  config.set_scenario("sea");
  EXPECT_EQ(config.scenario.sea, plant::Sea::jonswap);
  try {
    config.set_scenario("storm");
    ADD_FAILURE();
  } catch (const StartupError& error) {
    EXPECT_THAT(error.what(), HasSubstr("thesis-wave"));
  }
}

TEST(LabConfig, PerfectSensorsKeepTheWorldAndTheirFilters) {
  LabConfig config;
  config.use_perfect_sensors();
  EXPECT_EQ(config.world.camera.correlated_rms_m, 0);
  EXPECT_EQ(config.world.mru1.acceleration_bias_mps2.norm(), 0);
  EXPECT_TRUE(config.world.mru1.high_pass);
  EXPECT_EQ(config.world.mru1.output_latency_s, 0.005);
  EXPECT_EQ(config.world.differences.joint_bandwidth_factor, 0.9);
}

TEST(LabConfig, BeliefAsWorldTakesTheDifferencesAndLeavesWhiteNoise) {
  LabConfig config;
  config.use_belief_as_world();
  EXPECT_EQ(config.world.differences.joint_bandwidth_factor, 1.0);
  EXPECT_EQ(config.world.differences.wire_extra_m, 0);
  EXPECT_EQ(config.world.camera.correlated_rms_m, 0);
  EXPECT_GT(config.world.camera.marker_noise_rms_m, 0);
}

}  // namespace
}  // namespace motionlab::lab
