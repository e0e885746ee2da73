#include "simulators/mru/mru_device.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "drivers/mru/mru_driver.hpp"

namespace motionlab::mru {
namespace {

constexpr Endpoint kUnit{0xC0A85A0D, 50013};
constexpr Endpoint kGateway{0xC0A85A2B, 50043};

/// Hands every datagram to the driver at once, with the time of the step.
class Wire : public DatagramOut {
 public:
  Status send(Endpoint to, Bytes datagram) override {
    EXPECT_EQ(to, kGateway);
    sizes.push_back(datagram.size());
    if (driver) driver->on_datagram(datagram, kUnit, now);
    return Done{};
  }
  MruDriver* driver = nullptr;
  LabTime now{};
  std::vector<std::size_t> sizes;
};

/// Driver and unit joined on stepped time: the world samples every 5 ms, everybody steps every millisecond.
class MruPair {
 public:
  explicit MruPair(DeviceConfig device_config = {}, DriverConfig driver_config = {})
      : driver(std::move(driver_config), [this](const topic::Mru& sample) { samples.push_back(sample); }),
        device(to_gateway(std::move(device_config)), wire) {
    wire.driver = &driver;
  }

  static Reading reading_at(LabTime t) {
    const double s = seconds(t.time_since_epoch());
    Reading r;
    r.euler_heading_mru_rad = {0.1 * std::sin(s), 0.05 * std::cos(s), 0.3};
    r.omega_mru_radps = {0.1 * std::cos(s), -0.05 * std::sin(s), 0.01};
    r.omega_down_radps = 0.02;
    r.v_mru_mps = {1, 2, 3};
    r.a_mru_mps2 = {4, 5, 6};
    r.p_heading_origin_m = {0.7, 0.8, -0.9};
    r.v_heading_origin_mps = {1.1, 1.2, 1.3};
    r.a_heading_origin_mps2 = {1.4, 1.5, 1.6};
    return r;
  }

  void run(Nanoseconds duration) {
    for (const LabTime end = now + duration; now < end; now += 1ms) {
      wire.now = now;
      if ((now.time_since_epoch() % 5ms).count() == 0) device.measure(reading_at(now), now);
      device.step(now);
      driver.step(now);
    }
  }

  LabTime now = from_ns(1'000'000'000);
  std::vector<topic::Mru> samples;
  Wire wire;
  MruDriver driver;
  MruDevice device;

 private:
  static DeviceConfig to_gateway(DeviceConfig config) {
    config.to = kGateway;
    return config;
  }
};

TEST(MruPair, BringsEveryReadingAcrossWithItsTime) {
  MruPair pair;
  pair.run(2s);
  ASSERT_GT(pair.samples.size(), 390u);
  EXPECT_EQ(pair.driver.health().rejected_total(), 0u);
  EXPECT_EQ(pair.driver.health().lost(), 0u);
  for (const topic::Mru& s : pair.samples) {
    const LabTime t = from_ns(s.t_measured_ns);
    EXPECT_EQ(to_ns(t) % 5'000'000, 0);
    EXPECT_EQ(s.t_received_ns - s.t_measured_ns, 5'000'000);
    const Reading r = MruPair::reading_at(t);
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_NEAR(s.euler_heading_mru_rad[i], r.euler_heading_mru_rad[i], 1e-7);
      EXPECT_NEAR(s.omega_mru_radps[i], r.omega_mru_radps[i], 1e-7);
      EXPECT_NEAR(s.v_mru_mps[i], r.v_mru_mps[i], 1e-6);
      EXPECT_NEAR(s.a_mru_mps2[i], r.a_mru_mps2[i], 1e-6);
      EXPECT_NEAR(s.p_heading_origin_m[i], r.p_heading_origin_m[i], 1e-6);
      EXPECT_NEAR(s.v_heading_origin_mps[i], r.v_heading_origin_mps[i], 1e-6);
      EXPECT_NEAR(s.a_heading_origin_mps2[i], r.a_heading_origin_mps2[i], 1e-6);
    }
    EXPECT_NEAR(s.omega_down_radps, 0.02, 1e-8);
  }
  EXPECT_NEAR(pair.driver.health().rate_hz(pair.now), 200.0, 1.0);
}

TEST(MruPair, RunsThroughTheWrapOfSystemTime) {
  for (const std::uint32_t start : {0x7FFFFF00u, 0xFFFFFF00u}) {
    DeviceConfig config;
    config.system_time_start_ms = start;
    MruPair pair{config};
    pair.run(1s);
    EXPECT_EQ(pair.driver.health().rejected_total(), 0u);
    EXPECT_EQ(pair.driver.health().lost(), 0u);
    EXPECT_EQ(pair.driver.health().reconnects(), 0u);
    EXPECT_EQ(pair.samples.back().t_received_ns - pair.samples.back().t_measured_ns, 5'000'000);
  }
}

TEST(MruPair, FollowsADriftingClockThroughJitter) {
  for (const double ppm : {80.0, -80.0}) {
    DeviceConfig config;
    config.clock_drift_ppm = ppm;
    config.output_jitter_s = 0.002;
    MruPair pair{config};
    pair.run(60s);
    EXPECT_EQ(pair.driver.health().lost(), 0u);
    EXPECT_EQ(pair.driver.health().reconnects(), 0u);
    // Readings are taken at whole multiples of 5 ms, so the error of the stamp is its distance from one.
    for (std::size_t i = pair.samples.size() / 2; i < pair.samples.size(); ++i) {
      const double phase_ms = 1e-6 * static_cast<double>(pair.samples[i].t_measured_ns % 5'000'000);
      EXPECT_LT(std::min(phase_ms, 5.0 - phase_ms), 2.4) << ppm;
    }
  }
}

TEST(MruPair, SaysUnstableWhileSettling) {
  DeviceConfig config;
  config.settling_s = 0.5;
  MruPair pair{config};
  pair.run(1s);
  for (const topic::Mru& s : pair.samples) {
    EXPECT_EQ(s.stable, from_ns(s.t_measured_ns) >= from_ns(1'500'000'000));
  }
}

TEST(MruPair, LocksEitherChecksumRule) {
  for (const ChecksumRule rule : {ChecksumRule::sum8, ChecksumRule::ones_complement}) {
    DeviceConfig config;
    config.checksum_rule = rule;
    MruPair pair{config};
    pair.run(6s);
    EXPECT_EQ(pair.driver.checksum().rule(), rule);
    EXPECT_EQ(pair.driver.checksum().mismatches(), 0u);
  }
}

struct Expected {
  const char* fault;
  double value;
  Reason reason;
};

class MruFault : public ::testing::TestWithParam<Expected> {};

TEST_P(MruFault, IsCountedByTheDriverForItsReasonAndLeavesNoSample) {
  MruPair pair;
  pair.run(200ms);
  const auto before = pair.samples.size();
  ASSERT_TRUE(pair.device.set_fault(GetParam().fault, true, GetParam().value).ok());
  pair.run(500ms);
  EXPECT_LE(pair.samples.size(), before + 1);
  EXPECT_GE(pair.driver.health().rejected(GetParam().reason), 98u);
  EXPECT_EQ(pair.driver.health().phase(), LinkPhase::down);
  ASSERT_TRUE(pair.device.set_fault(GetParam().fault, false).ok());
  pair.run(200ms);
  EXPECT_GT(pair.samples.size(), before + 35);
  EXPECT_EQ(pair.driver.health().phase(), LinkPhase::up);
  EXPECT_TRUE(pair.driver.health().advice().empty());
}

INSTANTIATE_TEST_SUITE_P(
    All, MruFault,
    ::testing::Values(Expected{"truncate", 0, Reason::too_short}, Expected{"truncate", 60, Reason::too_short},
                      Expected{"oversize", 7, Reason::too_long},
                      Expected{"freeze_time", 0, Reason::duplicate}, Expected{"nan", 0, Reason::bad_value},
                      Expected{"wrong_token", 0, Reason::bad_header}),
    [](const auto& test) { return std::string{test.param.fault} + std::to_string(test.index); });

TEST(MruDevice, FallsSilentAndComesBack) {
  MruPair pair;
  pair.run(200ms);
  ASSERT_TRUE(pair.device.set_fault("silent", true).ok());
  pair.run(300ms);
  EXPECT_EQ(pair.driver.health().phase(), LinkPhase::down);
  ASSERT_TRUE(pair.device.set_fault("silent", false).ok());
  pair.run(100ms);
  EXPECT_EQ(pair.driver.health().phase(), LinkPhase::up);
  EXPECT_EQ(pair.driver.health().lost(), 60u);
}

TEST(MruDevice, SendsQWhenUnstable) {
  MruPair pair;
  ASSERT_TRUE(pair.device.set_fault("unstable", true).ok());
  pair.run(100ms);
  EXPECT_FALSE(pair.samples.back().stable);
}

TEST(MruDevice, RepeatsDatagrams) {
  MruPair pair;
  ASSERT_TRUE(pair.device.set_fault("repeat", true).ok());
  pair.run(1s);
  EXPECT_EQ(pair.driver.health().rejected(Reason::duplicate), pair.samples.size());
}

TEST(MruDevice, LosesTheShareItWasTold) {
  MruPair pair;
  ASSERT_TRUE(pair.device.set_fault("loss", true, 0.25).ok());
  pair.run(20s);
  EXPECT_NEAR(static_cast<double>(pair.driver.health().lost()), 1000.0, 100.0);
}

TEST(MruDevice, DelaysWithoutMovingTheStamp) {
  MruPair pair;
  pair.run(1s);
  ASSERT_TRUE(pair.device.set_fault("late", true, 0.03).ok());
  pair.run(1s);
  EXPECT_NEAR(
      1e-9 * static_cast<double>(pair.samples.back().t_received_ns - pair.samples.back().t_measured_ns),
      0.035, 1e-3);
}

TEST(MruDevice, ReordersSoThatTheDriverDropsTheOlder) {
  MruPair pair;
  ASSERT_TRUE(pair.device.set_fault("reorder", true).ok());
  pair.run(1s);
  EXPECT_NEAR(static_cast<double>(pair.driver.health().rejected(Reason::out_of_order)), 99.0, 2.0);
  for (std::size_t i = 1; i < pair.samples.size(); ++i) {
    EXPECT_GT(pair.samples[i].t_measured_ns, pair.samples[i - 1].t_measured_ns);
  }
}

TEST(MruDevice, CorruptsOneBitAndTheDriverNeverPassesItUnmarked) {
  DriverConfig config;
  config.checksum = {.policy = ChecksumPolicy::enforce, .rule = ChecksumRule::ones_complement};
  MruPair pair{{}, config};
  ASSERT_TRUE(pair.device.set_fault("corrupt", true).ok());
  pair.run(5s);
  // The header byte is not covered by the checksum, but q and Q differ in one bit: that one flip looks like
  // Q.
  for (const topic::Mru& s : pair.samples) EXPECT_FALSE(s.stable);
  EXPECT_GT(pair.driver.health().rejected(Reason::bad_checksum), 500u);
}

TEST(MruDevice, RestartsAndTheDriverStartsItsClockAfresh) {
  DeviceConfig config;
  config.settling_s = 0.2;
  MruPair pair{config};
  pair.run(3s);
  ASSERT_TRUE(pair.device.set_fault("restart", true).ok());
  pair.run(100ms);
  EXPECT_EQ(pair.driver.health().reconnects(), 1u);
  EXPECT_FALSE(pair.samples.back().stable);
  EXPECT_EQ(pair.samples.back().t_received_ns - pair.samples.back().t_measured_ns, 5'000'000);
}

TEST(MruDevice, RefusesAFaultItDoesNotKnowAndListsThoseItKnows) {
  MruPair pair;
  const Status status = pair.device.set_fault("explode", true);
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.fault().reason, Reason::refused);
  for (const char* name : {"silent", "unstable", "truncate", "oversize", "corrupt", "repeat", "freeze_time",
                           "nan", "wrong_token", "loss", "late", "reorder", "restart"}) {
    EXPECT_NE(status.fault().text.find(name), std::string_view::npos) << name;
    EXPECT_TRUE(pair.device.set_fault(name, false).ok()) << name;
  }
}

TEST(MruDevice, SaysWhenItWillSendNext) {
  MruPair pair;
  EXPECT_FALSE(pair.device.next_send());
  pair.device.measure({}, pair.now);
  EXPECT_EQ(pair.device.next_send(), pair.now + 5ms);
}

TEST(MruDevice, IsTheSameOnEveryRunWithTheSameSeed) {
  const auto run = [] {
    DeviceConfig config;
    config.output_jitter_s = 0.004;
    MruPair pair{config};
    EXPECT_TRUE(pair.device.set_fault("loss", true).ok());
    EXPECT_TRUE(pair.device.set_fault("corrupt", true, 0.1).ok());
    pair.run(5s);
    std::vector<std::int64_t> stamps;
    for (const topic::Mru& s : pair.samples) stamps.push_back(s.t_measured_ns ^ s.t_received_ns);
    return stamps;
  };
  EXPECT_EQ(run(), run());
}

}  // namespace
}  // namespace motionlab::mru
