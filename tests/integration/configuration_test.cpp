// A configuration that is not right is refused before a socket is opened, with its place and what to write.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <string>

#include "drivers/core/error.hpp"
#include "gateway/service/wiring.hpp"
#include "tests/integration/line.hpp"

namespace motionlab::integration {
namespace {

using service::load_gateway_config;
using testing::HasSubstr;
using testing::Not;

/// A folder of this test's own: tests run side by side.
std::filesystem::path overlay_folder() {
  std::string name = testing::UnitTest::GetInstance()->current_test_info()->name();
  std::replace(name.begin(), name.end(), '/', '_');
  const auto folder = std::filesystem::path(testing::TempDir()) / ("overlay_" + name);
  std::filesystem::create_directories(folder);
  return folder;
}

/// What start-up says about lab.toml, loopback.toml and this overlay; empty when it has nothing to say.
std::string complaint(const std::string& overlay) {
  const std::filesystem::path file = overlay_folder() / "overlay.toml";
  std::ofstream(file) << overlay;
  try {
    (void)load_gateway_config(config_file("lab.toml"), {config_file("loopback.toml"), file});
  } catch (const StartupError& error) {
    return error.what();
  }
  return {};
}

struct Mistake {
  std::string name;
  std::string overlay;
  std::string place;              ///< file:line:column
  std::vector<std::string> says;  ///< the key, and what to write instead
};
void PrintTo(const Mistake& mistake, std::ostream* out) {
  *out << mistake.name;
}

class WrongConfiguration : public testing::TestWithParam<Mistake> {};

TEST_P(WrongConfiguration, IsRefusedWithItsPlaceAndAdvice) {
  const std::string text = complaint(GetParam().overlay);
  ASSERT_FALSE(text.empty()) << "it was accepted";
  EXPECT_THAT(text, HasSubstr(GetParam().place));
  for (const auto& words : GetParam().says) EXPECT_THAT(text, HasSubstr(words));
}

INSTANTIATE_TEST_SUITE_P(
    OfTheGateway, WrongConfiguration,
    testing::Values(
        Mistake{"UnknownKey",
                "[mru1]\nstale_afer_s = 0.1\n",
                "overlay.toml:2:1",
                {"stale_afer_s", "stale_after_s"}},
        Mistake{"UnknownTable", "[mru3]\ntoken = 1\n", "overlay.toml:1", {"mru3"}},
        Mistake{"UnknownFormat", "[mru1]\nformat = \"mrubim\"\n", "overlay.toml:2", {"format", "mrubin"}},
        Mistake{"UnknownVariable",
                "[mru1]\nvariables = [63, 64, 9999]\n",
                "overlay.toml:2",
                {"variables", "unlisted"}},
        Mistake{"WrongUnit", "[mru1]\nperiod_ms = 5\n", "overlay.toml:2:1", {"period_ms", "period_s"}},
        Mistake{"UnknownWinchProfile",
                "[winch]\nprofile = \"old\"\n",
                "overlay.toml:2:",
                {"profile", "gvl_winch", "legacy"}},
        Mistake{"LegacyWinchTooFast",
                "[winch]\nlegacy_speed_max_mps = 0.5\n",
                "overlay.toml:2:",
                {"legacy_speed_max_mps", "0.2"}},
        Mistake{"WrongType", "[mru1]\nperiod_s = \"fast\"\n", "overlay.toml:2:", {"period_s", "number"}},
        Mistake{"OutOfRange",
                "\n[mru1]\nperiod_s = 5.0\n",
                "overlay.toml:3:",
                {"period_s", "out of range", "to 1"}},
        Mistake{"NotFinite", "[mru1]\nlatency_s = nan\n", "overlay.toml:2:", {"latency_s"}},
        Mistake{"BadEndpoint", "[mru1]\nlisten = \"127.0.0.1\"\n", "overlay.toml:2:", {"listen", ":50013"}},
        Mistake{"BadPort", "[mru1]\nlisten = \"127.0.0.1:70000\"\n", "overlay.toml:2:", {"listen"}},
        Mistake{"BadAddress", "[mru1]\nsource = \"localhost\"\n", "overlay.toml:2:", {"source"}},
        Mistake{"BadNetId", "[winch]\nnet_id = \"1.2.3\"\n", "overlay.toml:2:", {"net_id"}},
        Mistake{"NoRotation",
                "[calibration]\nworld_to_qtm = { q = [1.0, 1.0, 0.0, 0.0], p_m = [0.0, 0.0, 0.0] }\n",
                "overlay.toml:2:",
                {"q", "rotation"}},
        Mistake{"MinimumAboveMaximum",
                "[limits]\nq_min_deg = [45.0, -30.0, -135.0, -10.0, -10.0, -10.0]\n",
                "overlay.toml:2:",
                {"q_min_deg", "joint 1"}},
        Mistake{"WireMinimumAboveMaximum", "[limits]\nwire_min_m = 3.0\n", "overlay.toml:2:", {"wire_min_m"}},
        Mistake{"TooFewNumbers",
                "[limits]\nqd_max_degps = [30.0, 30.0]\n",
                "overlay.toml:2:",
                {"qd_max_degps", "6"}},
        Mistake{"UnknownWord", "[control]\nauthority = \"max\"\n", "overlay.toml:2:", {"authority", "full"}},
        Mistake{"AwakeWithoutAProcessor", "[control]\nawake = true\n", "overlay.toml:2:", {"awake", "cpu"}},
        Mistake{"BadToken", "[mru1]\ntoken = 256\n", "overlay.toml:2:", {"token", "255"}},
        Mistake{"BadSign", "[winch]\npay_out_sign = 0.5\n", "overlay.toml:2:", {"pay_out_sign"}},
        Mistake{
            "PlcAskedTooOften", "[plc_reply]\nperiod_s = 0.001\n", "overlay.toml:2:", {"period_s", "0.005"}},
        Mistake{"UnknownKeyOfThePlc", "[plc_reply]\nkey = 46505228\n", "overlay.toml:2:", {"key"}},
        Mistake{"PlcThatIsWaitedFor",
                "[modes]\nto_engage = [\"plc\"]\n",
                "overlay.toml:2:",
                {"to_engage", "plc is no device"}},
        Mistake{"NoToml", "[mru1\ntoken = 1\n", "overlay.toml:1:", {}},
        Mistake{"TwiceTheSameKey", "[mru1]\ntoken = 1\ntoken = 2\n", "overlay.toml:3:", {"token"}}),
    testing::PrintToStringParamName());

TEST(WrongConfigurationFile, ThatIsMissingOrAFolderIsNamed) {
  for (const std::filesystem::path file : {"/nonexistent/lab.toml", "/tmp"}) {
    try {
      (void)load_gateway_config(file);
      FAIL() << file << " was accepted";
    } catch (const StartupError& error) {
      EXPECT_THAT(error.what(), HasSubstr(file.string()));
    }
  }
}

TEST(WrongConfigurationFile, WithoutARequiredKeySaysWhichAndWhere) {
  std::ifstream original(config_file("lab.toml"));
  const auto file = std::filesystem::path(testing::TempDir()) / "shortened.toml";
  std::ofstream shortened(file);
  for (std::string line; std::getline(original, line);) {
    if (!line.starts_with("robot_computer")) shortened << line << '\n';
  }
  shortened.close();
  try {
    (void)load_gateway_config(file);
    FAIL() << "it was accepted";
  } catch (const StartupError& error) {
    EXPECT_THAT(error.what(), HasSubstr("shortened.toml:"));
    EXPECT_THAT(error.what(), HasSubstr("[comau]"));
    EXPECT_THAT(error.what(), HasSubstr("robot_computer"));
  }
}

TEST(Configuration, EveryFileThatIsDeliveredLoads) {
  EXPECT_NO_THROW((void)load_gateway_config(config_file("lab.toml")));
  EXPECT_NO_THROW((void)load_gateway_config(config_file("lab.toml"), {config_file("loopback.toml")}));
  EXPECT_NO_THROW((void)load_gateway_config(config_file("lab.toml"),
                                            {config_file("loopback.toml"), config_file("shared-vm.toml")}));
  EXPECT_NO_THROW((void)lab::LabConfig::load(config_file("world.toml")));
}

TEST(Configuration, WithoutAWatchdogTheJointsAreLimitedAndTheLogIsTold) {
  const auto laboratory = load_gateway_config(config_file("lab.toml"));
  for (const double fastest : laboratory.limits.qd_max_radps) EXPECT_LE(fastest, 0.1);
  ASSERT_EQ(laboratory.notes.size(), 1U);
  EXPECT_THAT(laboratory.notes.front(), HasSubstr("watchdog"));
  EXPECT_EQ(laboratory.comau.driver.qd_max_radps, laboratory.limits.qd_max_radps);

  const auto loopback = load_gateway_config(config_file("lab.toml"), {config_file("loopback.toml")});
  EXPECT_GT(loopback.limits.qd_max_radps[0], 0.5);
  EXPECT_TRUE(loopback.notes.empty());
}

TEST(Configuration, AnMruIsStuckAfterFivePeriodsAtAnyRate) {
  const auto with = [](const std::string& overlay) {
    const std::filesystem::path file = overlay_folder() / "overlay.toml";
    std::ofstream(file) << overlay;
    return load_gateway_config(config_file("lab.toml"), {file});
  };
  EXPECT_DOUBLE_EQ(with("").mrus.front().driver.stuck_after_s, 0.025);
  EXPECT_DOUBLE_EQ(with("[mru2]\nperiod_s = 0.1\n").mrus.back().driver.stuck_after_s, 0.5);
  EXPECT_DOUBLE_EQ(with("[mru1]\nstuck_after_s = 0\n").mrus.front().driver.stuck_after_s, 0.0);
}

TEST(Configuration, SaysWhatNoMruMayClaim) {
  const std::filesystem::path file = overlay_folder() / "overlay.toml";
  std::ofstream(file) << "[mru1]\ntilt_max_deg = 45\nheave_max_m = 2\nrate_max_radps = 1\n";
  const auto config = load_gateway_config(config_file("lab.toml"), {file});
  EXPECT_NEAR(config.mrus.front().driver.layout.limits.tilt_rad, 0.7853981634, 1e-9);
  EXPECT_EQ(config.mrus.front().driver.layout.limits.heave_m, 2.0);
  EXPECT_EQ(config.mrus.front().driver.layout.limits.rate_radps, 1.0);
  EXPECT_GE(config.mrus.back().driver.layout.limits.tilt_rad, 1.5707963) << "a right angle is allowed";
  EXPECT_EQ(config.mrus.back().driver.layout.limits.heave_m, 10.0);
}

TEST(Configuration, WiringNamesEveryDeviceItsAddressAndWhatIsRequired) {
  const auto config = load_gateway_config(config_file("lab.toml"), {config_file("loopback.toml")});
  const std::string text = service::wiring(config);
  for (const char* const words :
       {"mru1", "mru2", "qualisys", "arm", "winch", "127.0.0.1:50043", "127.0.0.1:50044", "127.0.0.1:22223",
        "127.0.0.1:50199", "127.0.0.1:50032", "127.0.0.1:50042", "127.0.0.1:48898", "192.168.90.150.1.1",
        "required", "DDS domain 42"}) {
    EXPECT_THAT(text, HasSubstr(words));
  }
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 7) << text;
}

TEST(Configuration, TheDrawingHasEveryEndOfEveryWire) {
  const auto config = load_gateway_config(config_file("lab.toml"));
  EXPECT_EQ(service::wiring_drawing(config),
            R"(                                          ┌─ motionlab-gateway ─┐
  mru1      192.168.90.13         ──udp─▶ │ 0.0.0.0:50043       │
  mru2      192.168.90.14         ──udp─▶ │ 0.0.0.0:50044       │
  qualisys  192.168.90.16:22223   ◀─tcp─▶ │ any port            │
            192.168.90.16         ──udp─▶ │ 0.0.0.0:50199       │
  arm       192.168.90.32:50032   ◀─udp─▶ │ 192.168.90.42:50042 │
  winch     192.168.90.150:48898  ◀─tcp─▶ │ any port            │
                                          └──┬──────────────────┘
                                             └─ DDS domain 42 on all interfaces, others are found by multicast
)");
}

TEST(Configuration, ThePlcsRemoteReplyIsWiredOnlyWhereItIsEnabled) {
  EXPECT_FALSE(load_gateway_config(config_file("lab.toml")).plc_reply);
  EXPECT_THAT(service::wiring(load_gateway_config(config_file("lab.toml"))), Not(HasSubstr("plc")));
  const std::filesystem::path file = overlay_folder() / "overlay.toml";
  std::ofstream(file) << "[plc_reply]\nenabled = true\neuler_order = \"zyx\"\nperiod_s = 0.05\n";
  const auto config = load_gateway_config(config_file("lab.toml"), {file});
  ASSERT_TRUE(config.plc_reply);
  EXPECT_EQ(config.plc_reply->driver.euler_order, plc_reply::EulerOrder::zyx);
  EXPECT_DOUBLE_EQ(config.plc_reply->driver.silent_after_s, 0.25);
  EXPECT_FALSE(config.plc_reply->rule.required);
  EXPECT_THAT(service::wiring(config),
              HasSubstr("plc\tasks udp 192.168.90.50:50050 from 192.168.90.60:50060"));
  EXPECT_THAT(service::wiring_drawing(config),
              HasSubstr("  plc       192.168.90.50:50050   ◀─udp─▶ │ 192.168.90.60:50060 │\n"));
}

TEST(Configuration, AFileWithoutTheTableOfThePlcsRemoteReplyIsStillOne) {
  std::ifstream original(config_file("lab.toml"));
  std::string text, section;
  for (std::string line; std::getline(original, line);) {
    if (line.starts_with("[")) section = line.substr(0, line.find(']'));
    if (section != "[plc_reply") text += line + '\n';
  }
  EXPECT_FALSE(service::parse_gateway_config({"older.toml", text}).plc_reply);
}

TEST(Configuration, OthersOnTheBusAreFoundInOneWay) {
  const auto wired = [](const std::string& overlay) {
    const std::filesystem::path file = overlay_folder() / "overlay.toml";
    std::ofstream(file) << overlay;
    return service::wiring(load_gateway_config(config_file("lab.toml"), {file}));
  };
  EXPECT_THAT(wired("[bus]\npeers = [\"192.168.90.71\", \"192.168.90.72\"]\nsecurity = \"identity\"\n"),
              HasSubstr("found at 192.168.90.71 192.168.90.72, protected\n"));
  EXPECT_THAT(wired("[bus]\nserver = \"192.168.90.72:11811\"\n"),
              HasSubstr("found by the discovery server 192.168.90.72:11811\n"));
  EXPECT_THAT(complaint("[bus]\npeers = [\"desk\"]\n"), HasSubstr("[bus] peers"));
  EXPECT_THAT(complaint("[bus]\nserver = \"192.168.90.72\"\n"), HasSubstr("[bus] server"));
  EXPECT_THAT(complaint("[bus]\npeers = [\"192.168.90.71\"]\nserver = \"192.168.90.72:11811\"\n"),
              HasSubstr("choose one of them"));
  EXPECT_THAT(complaint("[bus]\nserver = \"192.168.90.72:11811\"\nsecurity = \"identity\"\n"),
              HasSubstr("[bus] security"));
}

TEST(Configuration, APortInUseIsToldBeforeAnythingIsSent) {
  const lockstep::Config config = configure("calm");
  SteppedClock clock;
  MemoryNetwork network(clock);
  const auto occupied = network.datagram(config.gateway.mrus.front().listen);
  bus::LocalBus bus;
  service::ArmSchedule schedule;
  try {
    const service::Devices devices(config.gateway, network, bus, schedule);
    FAIL() << "the port was given twice";
  } catch (const StartupError& error) {
    EXPECT_THAT(error.what(), HasSubstr("127.0.0.1:50043"));
  }
  EXPECT_FALSE(network.next_due()) << "something was sent";
}

}  // namespace
}  // namespace motionlab::integration
