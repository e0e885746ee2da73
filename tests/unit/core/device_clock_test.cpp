#include "drivers/core/device_clock.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "drivers/core/random.hpp"

namespace motionlab {
namespace {

/// A device whose clock starts at `t_device_0` when the laboratory's is at 1000 s, and runs fast by `ppm`.
struct Device {
  Nanoseconds period{5ms};
  Nanoseconds t_device_0{0};
  double ppm = 0.0;
  LabTime t{1000s};

  void step() { t += period; }
  [[nodiscard]] Nanoseconds time() const {
    return t_device_0 + from_seconds(seconds(t - LabTime{1000s}) * (1.0 + 1e-6 * ppm));
  }
};

TEST(DeviceClock, MapsTheFirstSampleToItsArrivalLessTheConfiguredLatency) {
  DeviceClock clock({.latency = 3ms});
  EXPECT_EQ(clock.offset_s(), 0.0);
  EXPECT_EQ(clock.map(17s, LabTime{1000s}), LabTime{1000s - 3ms});
  EXPECT_DOUBLE_EQ(clock.offset_s(), 983.0);
}

TEST(DeviceClock, AConstantLatencyIsRemovedOnlyAsConfigured) {
  for (const Nanoseconds configured : {0ms, 3ms, 8ms}) {
    DeviceClock clock({.latency = configured});
    Device device;
    LabTime mapped{};
    for (int i = 0; i < 10000; ++i, device.step()) mapped = clock.map(device.time(), device.t + 8ms);
    device.t -= device.period;
    EXPECT_EQ(mapped, device.t + 8ms - configured);
    EXPECT_NEAR(clock.drift_ppm(), 0.0, 1e-6);
  }
}

TEST(DeviceClock, JitterLeavesAtMostItsFloor) {
  Random random(3);
  DeviceClock clock({.latency = 2ms});
  Device device;
  Nanoseconds worst_early{0};
  Nanoseconds worst_late{0};
  for (int i = 0; i < 60000; ++i, device.step()) {
    const LabTime mapped = clock.map(device.time(), device.t + 2ms + from_seconds(random.exponential(1e-3)));
    if (i < 400) continue;
    worst_early = std::max(worst_early, device.t - mapped);
    worst_late = std::max(worst_late, mapped - device.t);
  }
  EXPECT_LE(worst_late, 20us);
  EXPECT_LE(worst_early, 20us);
}

class DeviceClockDrift : public testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(Ppm, DeviceClockDrift, testing::Values(-150.0, -50.0, 0.0, 50.0, 150.0));

TEST_P(DeviceClockDrift, IsFollowedForAnHourThroughJitter) {
  Random random(5);
  DeviceClock clock({});
  Device device{.t_device_0 = 123456s, .ppm = GetParam()};
  Nanoseconds worst{0};
  double drift_error_ppm = 0.0;
  while (device.t < LabTime{1000s + 1h}) {
    const LabTime mapped = clock.map(device.time(), device.t + from_seconds(random.exponential(0.3e-3)));
    if (device.t > LabTime{1060s}) {
      worst = std::max({worst, mapped - device.t, device.t - mapped});
      drift_error_ppm = std::max(drift_error_ppm, std::abs(clock.drift_ppm() + GetParam()));
    }
    device.step();
  }
  EXPECT_LE(worst, 50us);
  EXPECT_LE(drift_error_ppm, 5.0);
}

TEST_P(DeviceClockDrift, IsNeverFarOffWhileItIsLearned) {
  DeviceClock clock({});
  Device device{.ppm = GetParam()};
  for (; device.t < LabTime{1060s}; device.step()) {
    const Nanoseconds error = clock.map(device.time(), device.t) - device.t;
    EXPECT_LE(error, 0ns);
    EXPECT_GE(error, -from_seconds(20.0 * 200e-6));
  }
}

TEST(DeviceClock, MappedTimeIsNeverLaterThanArrivalAndNeverGoesBack) {
  Random random(11);
  DeviceClock clock({.window = 1s});
  Device device{.period = 1ms, .ppm = -80.0};
  LabTime arrival = device.t;
  LabTime last{};
  for (int i = 0; i < 100000; ++i, device.step()) {
    double delay_s = random.exponential(2e-3);
    if (random.chance(0.001)) delay_s += 0.2;
    arrival = std::max(arrival, device.t + from_seconds(delay_s));
    const LabTime mapped = clock.map(device.time(), arrival);
    ASSERT_LE(mapped, arrival);
    ASSERT_GE(mapped, last);
    last = mapped;
  }
}

TEST(DeviceClock, ALateFirstSampleIsForgottenWithTheNext) {
  DeviceClock clock({});
  Device device;
  (void)clock.map(device.time(), device.t + 30ms);
  for (int i = 0; i < 10; ++i) {
    device.step();
    (void)clock.map(device.time(), device.t + 31ms - i * 3ms);
  }
  device.t += 1s;
  EXPECT_EQ(clock.map(device.time(), device.t + 5ms), device.t + 4ms);
}

TEST(DeviceClock, ARouteThatBecomesSlowerIsCreptUpToWithinTheBound) {
  DeviceClock clock({.window = 1s, .drift_ppm_max = 200.0});
  Device device;
  for (; device.t < LabTime{1010s}; device.step()) (void)clock.map(device.time(), device.t);
  LabTime last = device.t - device.period;
  for (; device.t < LabTime{1040s}; device.step()) {
    const LabTime mapped = clock.map(device.time(), device.t + 1ms);
    EXPECT_LE(mapped - last, device.period + 3us);  // drift and creep, 200 ppm each
    last = mapped;
  }
  EXPECT_NEAR(seconds(last + device.period - device.t), 1e-3, 50e-6);
}

TEST(DeviceClock, ADeviceThatStartsAgainFromZeroStartsAfresh) {
  DeviceClock clock({});
  Device device{.t_device_0 = 5000s};
  for (; device.t < LabTime{1030s}; device.step()) (void)clock.map(device.time(), device.t + 1ms);
  device.t_device_0 = -29s;
  EXPECT_EQ(clock.map(device.time(), device.t + 2ms), device.t + 2ms);
  EXPECT_EQ(clock.drift_ppm(), 0.0);
  device.step();
  EXPECT_EQ(clock.map(device.time(), device.t + 1ms), device.t + 1ms);
}

TEST(DeviceClock, ADeviceClockThatJumpsAheadStartsAfresh) {
  DeviceClock clock({});
  Device device;
  for (; device.t < LabTime{1030s}; device.step()) (void)clock.map(device.time(), device.t + 1ms);
  device.t_device_0 = 10s;
  EXPECT_EQ(clock.map(device.time(), device.t + 1ms), device.t + 1ms);
}

TEST(DeviceClock, ABurstAfterASilenceKeepsItsTrueOldTimes) {
  DeviceClock clock({});
  Device device;
  for (; device.t < LabTime{1005s}; device.step()) (void)clock.map(device.time(), device.t);
  const LabTime burst = device.t + 900ms;
  for (; device.t < burst; device.step()) EXPECT_EQ(clock.map(device.time(), burst), device.t);
}

TEST(DeviceClock, ADeviceClockThatLostTimeIsBelievedAfterASecond) {
  DeviceClock clock({});
  Device device;
  for (; device.t < LabTime{1005s}; device.step()) (void)clock.map(device.time(), device.t);
  device.t_device_0 = -2s;
  device.t += 4s;  // silent meanwhile, so that its time did not go back
  const LabTime resumed = device.t;
  for (; device.t < resumed + 2s; device.step()) {
    const LabTime mapped = clock.map(device.time(), device.t);
    EXPECT_EQ(mapped, device.t <= resumed + 1s ? device.t - 2s : device.t);
  }
}

TEST(DeviceClock, ResetForgetsEverything) {
  DeviceClock clock({});
  Device device;
  for (; device.t < LabTime{1005s}; device.step()) (void)clock.map(device.time(), device.t);
  clock.reset();
  EXPECT_EQ(clock.offset_s(), 0.0);
  EXPECT_EQ(clock.map(device.time(), device.t + 7ms), device.t + 7ms);
}

}  // namespace
}  // namespace motionlab
