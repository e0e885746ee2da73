#include "simulators/lab/simulated_lab.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <optional>
#include <vector>

#include "drivers/comau/comau_wire.hpp"
#include "drivers/core/memory_network.hpp"
#include "drivers/mru/mru_wire.hpp"

namespace motionlab::lab {
namespace {

/// The laboratory on a memory network, and somebody at the other end of its wires.
class Lab : public testing::Test {
 protected:
  struct Arrival {
    std::vector<std::uint8_t> bytes;
    LabTime t;
  };

  void build(LabConfig config = {}) {
    config_ = config;
    mru1_ = listen(config.mru1.device.to, from_mru1_);
    mru2_ = listen(config.mru2.device.to, from_mru2_);
    arm_ = listen(Endpoint::parse("127.0.0.1:50042"), from_arm_);
    lab_ = std::make_unique<SimulatedLab>(config, network_, clock_.now());
  }

  void run(Nanoseconds duration, Nanoseconds by = 400us) {
    const LabTime end = clock_.now() + duration;
    while (clock_.now() < end) {
      network_.run_until(std::min(end, clock_.now() + by));
      if (command_) send_command();
      lab_->step(clock_.now());
    }
    network_.deliver_due(clock_.now());
  }

  void send_command() { (void)arm_->send(config_.arm_listen, comau::encode(*command_)); }

  std::unique_ptr<DatagramSocket> listen(Endpoint at, std::vector<Arrival>& to) {
    auto socket = network_.datagram(at);
    socket->on_datagram([&to](Bytes bytes, Endpoint, LabTime t) {
      to.push_back({{bytes.begin(), bytes.end()}, t});
    });
    return socket;
  }

  SteppedClock clock_;
  MemoryNetwork network_{clock_};
  LabConfig config_;
  std::vector<Arrival> from_mru1_, from_mru2_, from_arm_;
  std::unique_ptr<DatagramSocket> mru1_, mru2_, arm_;
  std::unique_ptr<SimulatedLab> lab_;
  std::optional<comau::Command> command_;
};

TEST_F(Lab, BothMrusSpeakTwoHundredTimesASecondWithTheirTokensAndTheirLatency) {
  build();
  run(1s);
  EXPECT_NEAR(static_cast<double>(from_mru1_.size()), 199, 1);
  EXPECT_NEAR(static_cast<double>(from_mru2_.size()), 199, 1);
  ASSERT_FALSE(from_mru1_.empty());
  const auto frame = mru::decode(from_mru1_[0].bytes, mru::Layout{.token = 11});
  ASSERT_TRUE(frame);
  EXPECT_TRUE(mru::decode(from_mru2_[0].bytes, mru::Layout{.token = 12}));
  // 5 ms of the unit and 3 ms of the difference, rounded up to the steps of this test.
  EXPECT_GE(from_mru1_[0].t, LabTime{} + 8ms);
  EXPECT_LE(from_mru1_[0].t, LabTime{} + 8400us);
}

TEST_F(Lab, TheTruthStandsStillInACalmAndTheTwinBesideIt) {
  LabConfig config;
  config.set_scenario("calm");
  build(config);
  run(2s);
  const topic::TruthWorld truth = lab_->truth();
  EXPECT_EQ(truth.t_ns, to_ns(clock_.now()));
  EXPECT_EQ(truth.sequence_number, 1U);
  EXPECT_LT(std::hypot(truth.swing_rad[0], truth.swing_rad[1]), 1e-4);
  EXPECT_NEAR(truth.p_world_load_m[2], truth.p_world_twin_load_m[2], 1e-3);
  EXPECT_NEAR(truth.wire_tension_n, 12 * 9.81, 0.5);
  EXPECT_NEAR(truth.wire_length_m, 2.002, 1e-6);
  EXPECT_EQ(lab_->truth().sequence_number, 2U);
}

TEST_F(Lab, TheArmFollowsAVelocityFromTheWire) {
  LabConfig config;
  config.set_scenario("calm");
  build(config);
  run(1500ms, 5ms);
  command_ = comau::Command{};
  command_->mode = static_cast<std::int32_t>(comau::Mode::follow);
  command_->qd_radps[0] = 0.1F;
  run(2s, 5ms);
  // 0.2 rad less the lag 2 zeta / omega and the delay.
  EXPECT_NEAR(lab_->truth().q_rad[0], 0.2 - 0.1 * (1.4 / (0.9 * 25.1327) + 0.0024), 0.001);
  ASSERT_FALSE(from_arm_.empty());
  const auto answer = comau::decode_answer(from_arm_.back().bytes);
  ASSERT_TRUE(answer);
  EXPECT_NEAR(answer->q_rad[0], lab_->truth().q_rad[0], 0.001);
}

TEST_F(Lab, TheBrakesHoldTheArmWhenItsDrivesDrop) {
  LabConfig config;
  config.set_scenario("calm");
  build(config);
  run(1500ms, 5ms);
  command_ = comau::Command{};
  command_->mode = static_cast<std::int32_t>(comau::Mode::follow);
  command_->qd_radps[0] = 0.1F;
  run(1s, 5ms);
  ASSERT_TRUE(lab_->set_fault("arm", "drive_off", true));
  run(1s, 5ms);
  const double held = lab_->truth().q_rad[0];
  run(1s, 5ms);
  EXPECT_NEAR(lab_->truth().q_rad[0], held, 1e-5);
}

TEST_F(Lab, ASilentUnitIsSilentAndComesBack) {
  build();
  run(500ms);
  ASSERT_TRUE(lab_->set_fault("mru1", "silent", true));
  run(100ms);
  const std::size_t then = from_mru1_.size();
  const std::size_t other = from_mru2_.size();
  run(500ms);
  EXPECT_EQ(from_mru1_.size(), then);
  EXPECT_GT(from_mru2_.size(), other + 90);
  ASSERT_TRUE(lab_->set_fault("mru1", "silent", false));
  run(500ms);
  EXPECT_GT(from_mru1_.size(), then + 90);
}

TEST_F(Lab, RefusesFaultsAndDevicesItDoesNotHaveAndNamesThoseItHas) {
  build();
  EXPECT_FALSE(lab_->set_fault("mru9", "silent", true));
  EXPECT_THAT(std::string(lab_->set_fault("mru9", "silent", true).fault().text),
              testing::HasSubstr("qualisys"));
  for (const char* device : {"mru1", "mru2", "qualisys", "arm", "winch"}) {
    const Status status = lab_->set_fault(device, "no such fault", true);
    ASSERT_FALSE(status) << device;
    EXPECT_THAT(std::string(status.fault().text), testing::HasSubstr("silent")) << device;
  }
}

TEST_F(Lab, CatchesUpAfterAStallWithoutLosingATick) {
  LabConfig config;
  build(config);
  run(1s);
  const auto smooth = lab_->truth();

  MemoryNetwork other(clock_);
  SimulatedLab stalled(config, other, LabTime{});
  stalled.step(clock_.now());
  EXPECT_EQ(stalled.truth().p_world_twin_load_m, smooth.p_world_twin_load_m);
  EXPECT_GT(stalled.next_event(), clock_.now());
}

TEST_F(Lab, TheSameSeedGivesTheSameBytes) {
  const auto bytes_of = [](std::uint64_t seed) {
    SteppedClock clock;
    MemoryNetwork network(clock);
    LabConfig config;
    config.seed = seed;
    std::vector<std::uint8_t> all;
    auto socket = network.datagram(config.mru1.device.to);
    socket->on_datagram(
        [&](Bytes bytes, Endpoint, LabTime) { all.insert(all.end(), bytes.begin(), bytes.end()); });
    SimulatedLab lab(config, network, clock.now());
    for (int i = 0; i < 2000; ++i) {
      network.run_until(clock.now() + 1ms);
      lab.step(clock.now());
    }
    return all;
  };
  const auto a = bytes_of(1);
  EXPECT_GT(a.size(), 30000U);
  EXPECT_EQ(a, bytes_of(1));
  EXPECT_NE(a, bytes_of(2));
}

TEST_F(Lab, RefusesToStartWhenAnAddressIsTaken) {
  build();
  EXPECT_THROW(SimulatedLab(config_, network_, clock_.now()), std::exception);
}

TEST_F(Lab, EveryFaultThatItNamesIsKnownAndEveryNameOfARefusalIsNamed) {
  build();
  for (const std::string device : {"mru1", "mru2", "qualisys", "arm", "winch"}) {
    const auto names = lab_->fault_names(device);
    for (const std::string& name : names) {
      const Status done = lab_->set_fault(device, name, true);
      EXPECT_TRUE(done.ok() || done.fault().text.find("unknown") == std::string_view::npos) << device << name;
      (void)lab_->set_fault(device, name, false);
    }
    std::string told{lab_->set_fault(device, "?", true).fault().text};
    std::replace(told.begin(), told.end(), ',', ' ');
    std::istringstream words(told.substr(told.find("off"), told.find("; and ok ends") - told.find("off")));
    for (std::string word; words >> word;) {
      if (word.back() == ';' || word.back() == ':') word.pop_back();
      if (word == "its" || word == "wire" || word == "occlude:<body>") continue;
      EXPECT_THAT(names, testing::Contains(word)) << device;
    }
  }
  EXPECT_THAT(lab_->fault_names("qualisys"), testing::Contains("occlude:platform"));
  EXPECT_TRUE(lab_->fault_names("crane").empty());
}

TEST_F(Lab, OkEndsEveryFaultOfADeviceAndOfItsWireAndNothingElse) {
  build();
  run(100ms);
  ASSERT_TRUE(lab_->set_fault("mru1", "silent", true));
  ASSERT_TRUE(lab_->set_fault("mru1", "cut", true));
  ASSERT_TRUE(lab_->set_fault("mru2", "silent", true));
  run(20ms);  // what was under way arrives
  from_mru1_.clear();
  from_mru2_.clear();
  ASSERT_TRUE(lab_->set_fault("mru1", "ok", false)) << "it is known, and ends nothing before it begins";
  run(100ms);
  EXPECT_TRUE(from_mru1_.empty());
  ASSERT_TRUE(lab_->set_fault("mru1", "ok", true));
  run(100ms);
  EXPECT_NEAR(static_cast<double>(from_mru1_.size()), 20, 2);
  EXPECT_TRUE(from_mru2_.empty());
  for (const char* const device : {"mru2", "qualisys", "arm", "winch", "world"}) {
    EXPECT_TRUE(lab_->set_fault(device, "ok", true)) << device;
  }
  EXPECT_FALSE(lab_->set_fault("crane", "ok", true));
}

TEST_F(Lab, AGustPushesTheLoadTheWayItBlowsUntilItEnds) {
  LabConfig calm;
  calm.set_scenario("calm");
  build(calm);
  const Eigen::Vector3d before = lab_->state().crane.p_WL;
  ASSERT_TRUE(lab_->set_fault("world", "gust:90", true, 12));
  run(100ms);
  const Eigen::Vector3d off = lab_->state().crane.p_WL - before;
  EXPECT_NEAR(off.y(), 0.5 * 1.0 * 0.1 * 0.1, 2e-4) << "a metre per second squared";
  EXPECT_NEAR(off.x(), 0, 1e-5);
  ASSERT_TRUE(lab_->set_fault("world", "gust:90", false));
  run(1ms);  // the tick that had begun ends
  const double v = lab_->state().crane.v_WL.y();
  run(2ms);
  EXPECT_LE(lab_->state().crane.v_WL.y(), v) << "it swings on freely";
  EXPECT_FALSE(lab_->set_fault("world", "gust:north", true));
  EXPECT_THAT(std::string(lab_->set_fault("world", "rain", true).fault().text), testing::HasSubstr("gust"));
}

}  // namespace
}  // namespace motionlab::lab
