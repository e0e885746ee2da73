/// @file  Driver and simulated unit joined in memory on stepped time.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <utility>
#include <vector>

#include "drivers/mru/mru_driver.hpp"
#include "simulators/mru/mru_device.hpp"

namespace motionlab::mru {

inline constexpr Endpoint kUnit{0xC0A85A0D, 50013};
inline constexpr Endpoint kGateway{0xC0A85A2B, 50043};

/// Hands every datagram to the driver at once, with the time of the step.
class Wire : public DatagramOut {
 public:
  Status send(Endpoint to, Bytes datagram) override {
    EXPECT_EQ(to, kGateway);
    if (driver) driver->on_datagram(datagram, kUnit, now);
    return Done{};
  }
  MruDriver* driver = nullptr;
  LabTime now{};
};

/// The world samples every 5 ms, everybody steps every millisecond.
class MruPair {
 public:
  explicit MruPair(DeviceConfig device_config = {}, DriverConfig driver_config = {})
      : driver(std::move(driver_config), [this](const topic::Mru& sample) { samples.push_back(sample); }),
        device(to_gateway(std::move(device_config)), wire) {
    wire.driver = &driver;
  }

  /// Both ends in one format.
  static MruPair speaking(Format format) {
    DeviceConfig device;
    device.format = format;
    DriverConfig driver;
    driver.format = format;
    return MruPair{device, driver};
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

}  // namespace motionlab::mru
