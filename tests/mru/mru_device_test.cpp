#include "simulators/mru/mru_device.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/mru/mru_pair.hpp"

namespace motionlab::mru {
namespace {

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

TEST(MruPair, BringsTheAttitudeAcrossInEveryFormat) {
  for (const Format format : kFormats) {
    MruPair pair = MruPair::speaking(format);
    pair.run(2s);
    ASSERT_GT(pair.samples.size(), 390u) << to_string(format);
    EXPECT_EQ(pair.driver.health().rejected_total(), 0u) << to_string(format);
    EXPECT_EQ(pair.driver.health().lost(), 0u);
    for (const topic::Mru& s : pair.samples) {
      const Reading r = MruPair::reading_at(from_ns(s.t_measured_ns));
      EXPECT_TRUE(s.stable);
      EXPECT_EQ(s.t_received_ns - s.t_measured_ns, 5'000'000) << to_string(format);
      EXPECT_NEAR(s.euler_heading_mru_rad[0], r.euler_heading_mru_rad[0], 2e-4) << to_string(format);
      EXPECT_NEAR(s.euler_heading_mru_rad[1], r.euler_heading_mru_rad[1], 2e-4) << to_string(format);
      EXPECT_TRUE(format == Format::tss1 || std::abs(s.euler_heading_mru_rad[2] - 0.3) < 2e-4);
      EXPECT_TRUE(format == Format::prdid || std::abs(s.p_heading_origin_m[2] + 0.9) < 0.006);
    }
  }
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

TEST(MruDevice, FallsSilentAndComesBackWithItsClockRunningOn) {
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

TEST(MruDevice, BootsAfterItWasOff) {
  DeviceConfig config;
  config.settling_s = 0.2;
  MruPair pair{config};
  pair.run(3s);
  ASSERT_TRUE(pair.device.set_fault("off", true).ok());
  pair.run(300ms);
  const std::uint64_t sent = pair.device.sent();
  pair.run(300ms);
  EXPECT_EQ(pair.device.sent(), sent);
  ASSERT_TRUE(pair.device.set_fault("off", false).ok());
  pair.run(100ms);
  EXPECT_FALSE(pair.samples.back().stable);
  EXPECT_EQ(pair.driver.health().reconnects(), 1u);
  pair.run(200ms);
  EXPECT_TRUE(pair.samples.back().stable);
}

TEST(MruDevice, DelaysWithoutMovingTheStamp) {
  MruPair pair;
  pair.run(1s);
  ASSERT_TRUE(pair.device.set_fault("delayed", true, 0.03).ok());
  pair.run(1s);
  EXPECT_NEAR(
      1e-9 * static_cast<double>(pair.samples.back().t_received_ns - pair.samples.back().t_measured_ns),
      0.035, 1e-3);
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
  for (const char* name :
       {"off", "stuck", "garbage", "wrong", "slow", "delayed", "intermittent", "silent", "unstable",
        "reduced", "freeze_time", "nan", "wrong_token", "bad_checksum", "oversize", "restart"}) {
    EXPECT_NE(status.fault().text.find(name), std::string_view::npos) << name;
    EXPECT_TRUE(pair.device.set_fault(name, false).ok()) << name;
  }
}

TEST(MruDevice, RefusesAFaultThatItsFormatCannotHave) {
  struct Impossible {
    Format format;
    const char* fault;
  };
  for (const auto& [format, fault] :
       {Impossible{Format::km_binary, "wrong_token"}, Impossible{Format::em3000, "freeze_time"},
        Impossible{Format::em1000, "unstable"}, Impossible{Format::prdid, "unstable"},
        Impossible{Format::tss1, "bad_checksum"}, Impossible{Format::mrubin, "reduced"},
        Impossible{Format::psxn, "freeze_time"}}) {
    MruPair pair = MruPair::speaking(format);
    const Status status = pair.device.set_fault(fault, true);
    ASSERT_FALSE(status.ok()) << to_string(format) << " " << fault;
    EXPECT_EQ(status.fault().reason, Reason::refused);
    EXPECT_TRUE(pair.device.set_fault(fault, false).ok()) << "to end a fault is always right";
  }
}

TEST(MruDevice, SaysWhenItWillSendNext) {
  MruPair pair;
  EXPECT_FALSE(pair.device.next_send());
  pair.device.measure({}, pair.now);
  EXPECT_EQ(pair.device.next_send(), pair.now + 5ms);
}

TEST(MruDevice, IsTheSameOnEveryRunWithTheSameSeed) {
  const auto run = [](std::uint64_t seed) {
    DeviceConfig config;
    config.output_jitter_s = 0.004;
    config.seed = seed;
    MruPair pair{config};
    EXPECT_TRUE(pair.device.set_fault("intermittent", true).ok());
    pair.run(5s);
    std::vector<std::int64_t> stamps;
    for (const topic::Mru& s : pair.samples) stamps.push_back(s.t_measured_ns ^ s.t_received_ns);
    return stamps;
  };
  EXPECT_EQ(run(1), run(1));
  EXPECT_NE(run(1), run(2));
}

}  // namespace
}  // namespace motionlab::mru
