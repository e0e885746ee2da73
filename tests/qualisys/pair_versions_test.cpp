// Driver and simulated server joined in memory: every newest version that a server may have, in both byte
// orders, by datagram and over the connection, with and without camera time.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "drivers/core/memory_network.hpp"
#include "drivers/qualisys/qualisys_driver.hpp"
#include "simulators/qualisys/qualisys_device.hpp"

namespace motionlab::qualisys {
namespace {

using State = QualisysDriver::State;

constexpr Endpoint kLittle{0x7f000001, 22223};
constexpr Endpoint kBig{0x7f000001, 22224};
constexpr Endpoint kQtmUdp{0x7f000001, 41000};
constexpr Endpoint kStream{0x7f000001, 50199};

/// Newest version 1.n, byte order, over UDP, camera time.
using Kind = std::tuple<int, std::endian, bool, bool>;

class QualisysVersions : public testing::TestWithParam<Kind> {
 protected:
  static DeviceConfig device_config() {
    DeviceConfig c;
    c.newest_version_minor = std::get<0>(GetParam());
    if (std::get<3>(GetParam())) c.timecode = TimecodeSource::camera;
    c.camera_time_offset_s = 1000.0;
    return c;
  }
  static DriverConfig driver_config() {
    DriverConfig c;
    c.byte_order = std::get<1>(GetParam());
    c.udp_port = std::get<2>(GetParam()) ? kStream.port : std::uint16_t{0};
    c.hook.name = "hook";
    return c;
  }
  QualisysVersions() {
    little->on_event(&device);
    big->on_event(&device.serve_big_endian(*big));
    client->on_event(&driver);
    stream->on_datagram([this](Bytes b, Endpoint from, LabTime t) { driver.on_datagram(b, from, t); });
  }
  void run(Nanoseconds duration) {
    for (const LabTime end = clock.now() + duration; clock.now() < end;) {
      network.run_until(clock.now() + 1ms);
      const LabTime now = clock.now();
      if (now.time_since_epoch() % 5ms == 0ns) {
        CameraFrame frame;
        const double x_m = seconds(now.time_since_epoch());
        frame.bodies.push_back({"load", true, {x_m, 2.0, 3.0}, {0.6, 0.0, 0.8, 0.0}, 0.0004});
        frame.unlabelled = {{{x_m, 1.0, 2.0}, 7, 0.0}, {{x_m, 1.062, 2.0}, 8, 0.0}};
        device.capture(frame, now);
      }
      device.step(now);
      driver.step(now);
    }
  }

  SteppedClock clock;
  MemoryNetwork network{clock, {.latency = 100us}};
  std::unique_ptr<StreamServer> little = network.server(kLittle);
  std::unique_ptr<StreamServer> big = network.server(kBig);
  std::unique_ptr<DatagramSocket> qtm_udp = network.datagram(kQtmUdp);
  std::unique_ptr<DatagramSocket> stream = network.datagram(kStream);
  std::unique_ptr<StreamClient> client =
      network.client(std::get<1>(GetParam()) == std::endian::little ? kLittle : kBig);
  std::vector<topic::Bodies> samples;
  QualisysDevice device{device_config(), *little, *qtm_udp};
  QualisysDriver driver{driver_config(), *client, [this](const topic::Bodies& s) { samples.push_back(s); }};
};

TEST_P(QualisysVersions, SpeakTheNewestThatBothKnowOrSayThatThereIsNone) {
  const int newest = std::get<0>(GetParam());
  run(2s);
  if (newest < 21) {
    EXPECT_THAT(std::string{driver.health().advice()}, testing::HasSubstr("1.25 to 1.21"));
    EXPECT_GE(driver.health().rejected(Reason::refused), 1u);
    EXPECT_TRUE(samples.empty());
    return;
  }
  EXPECT_EQ(driver.version_minor(), std::min(newest, 25));
  ASSERT_EQ(driver.state(), State::streaming);
  EXPECT_EQ(driver.health().advice(), "");
  EXPECT_EQ(driver.health().rejected_total(), 0u);
  EXPECT_EQ(driver.orientation(), OrientationCheck::Verdict::agree);
  ASSERT_GT(samples.size(), 2u * 350);
  for (const topic::Bodies& sample : samples) {
    ASSERT_TRUE(sample.tracked);
    EXPECT_NEAR(sample.p_camera_body_m[0], 1e-9 * static_cast<double>(sample.t_measured_ns), 0.0002)
        << "at 1 m/s the network's 0.1 ms, which no clock filter can see, is 0.1 mm";
    EXPECT_NEAR(sample.p_camera_body_m[1], sample.body.view() == "load" ? 2.0 : 1.031, 1e-6);
  }
}

INSTANTIATE_TEST_SUITE_P(Newest, QualisysVersions,
                         testing::Combine(testing::Range(8, 29),
                                          testing::Values(std::endian::little, std::endian::big),
                                          testing::Bool(), testing::Bool()),
                         [](const auto& test) {
                           return "1_" + std::to_string(std::get<0>(test.param)) +
                                  (std::get<1>(test.param) == std::endian::little ? "_little" : "_big") +
                                  (std::get<2>(test.param) ? "_udp" : "_tcp") +
                                  (std::get<3>(test.param) ? "_camera_time" : "");
                         });

}  // namespace
}  // namespace motionlab::qualisys
