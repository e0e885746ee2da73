// Driver and simulated server joined in memory, on stepped time.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "drivers/core/memory_network.hpp"
#include "drivers/qualisys/qualisys_driver.hpp"
#include "simulators/qualisys/qualisys_device.hpp"

namespace motionlab::qualisys {
namespace {

using testing::HasSubstr;
using State = QualisysDriver::State;

constexpr Endpoint kControl{0x7f000001, 22223};
constexpr Endpoint kQtmUdp{0x7f000001, 41000};
constexpr Endpoint kStream{0x7f000001, 50199};

class QualisysPair : public testing::Test {
 protected:
  static DeviceConfig device_config() {
    DeviceConfig c;
    c.bodies = {{"Platform", true}, {"Load", true}};
    return c;
  }
  static DriverConfig driver_config() {
    DriverConfig c;
    c.bodies = {"load", "platform"};
    c.server_address = kStream.address;
    c.udp_port = kStream.port;
    return c;
  }

  QualisysPair() {
    server->on_event(&device);
    client->on_event(&driver);
    stream->on_datagram([this](Bytes b, Endpoint from, LabTime t) { driver.on_datagram(b, from, t); });
  }

  /// Where the load is at a time: a swing that no filter may delay unseen.
  static double swing_m(LabTime t) { return 0.5 * std::sin(2.0 * seconds(t.time_since_epoch())); }

  /// Runs the world; the cameras expose every 5 ms.
  void run(Nanoseconds duration) {
    for (const LabTime end = clock.now() + duration; clock.now() < end;) {
      network.run_until(clock.now() + 1ms);
      const LabTime now = clock.now();
      if (exposing && now.time_since_epoch() % 5ms == 0ns) {
        CameraFrame frame;
        frame.bodies.push_back({"load", true, {swing_m(now), 2.0, 3.0}, {0.6, 0.0, 0.8, 0.0}, 0.0004});
        frame.bodies.push_back({"platform", true, {-1.0, 0.0, 0.5}, {1.0, 0.0, 0.0, 0.0}, 0.0002});
        device.capture(frame, now);
      }
      device.step(now);
      driver.step(now);
    }
  }

  [[nodiscard]] const topic::Bodies& last(std::string_view body) const {
    const auto found = std::find_if(samples.rbegin(), samples.rend(),
                                    [&](const topic::Bodies& s) { return s.body.view() == body; });
    return *found;
  }
  [[nodiscard]] std::size_t tracked() const {
    return static_cast<std::size_t>(
        std::count_if(samples.begin(), samples.end(), [](const topic::Bodies& s) { return s.tracked; }));
  }
  [[nodiscard]] std::uint64_t rejected(Reason reason) const { return driver.health().rejected(reason); }

  SteppedClock clock;
  MemoryNetwork network{clock, {.latency = 100us}};
  std::unique_ptr<StreamServer> server = network.server(kControl);
  std::unique_ptr<DatagramSocket> qtm_udp = network.datagram(kQtmUdp);
  std::unique_ptr<StreamClient> client = network.client(kControl);
  std::unique_ptr<DatagramSocket> stream = network.datagram(kStream);
  std::vector<topic::Bodies> samples;
  QualisysDevice device{device_config(), *server, *qtm_udp};
  QualisysDriver driver{driver_config(), *client, [this](const topic::Bodies& s) { samples.push_back(s); }};
  bool exposing = true;
};

TEST_F(QualisysPair, ConnectsAndTellsEveryFrameOfEveryWantedBody) {
  run(3s);
  EXPECT_EQ(driver.state(), State::streaming);
  EXPECT_EQ(driver.health().phase(), LinkPhase::up);
  EXPECT_EQ(driver.health().advice(), "");
  EXPECT_EQ(driver.health().rejected_total(), 0u);
  EXPECT_EQ(driver.health().lost(), 0u);
  EXPECT_NEAR(driver.health().rate_hz(clock.now()), 200.0, 3.0);
  EXPECT_GT(samples.size(), 2u * 590);
  EXPECT_EQ(tracked(), samples.size());
  EXPECT_EQ(driver.qtm_version(), "QTM Version is 2.17 (build 3700)");
}

TEST_F(QualisysPair, GivesTheExposuresTimeAndPose) {
  run(3s);
  const topic::Bodies& load = last("load");
  // At 1 m/s the network's 0.1 ms, which no clock filter can see, is 0.1 mm.
  EXPECT_NEAR(load.p_camera_body_m[0], swing_m(from_ns(load.t_measured_ns)), 0.0002);
  EXPECT_NEAR(1e-9 * static_cast<double>(load.t_received_ns - load.t_measured_ns), 0.007, 0.0002);
  EXPECT_NEAR(load.p_camera_body_m[1], 2.0, 1e-6);
  EXPECT_NEAR(load.q_camera_body[0], 0.6, 1e-6);
  EXPECT_NEAR(load.q_camera_body[2], 0.8, 1e-6);
  EXPECT_NEAR(load.residual_m, 0.0004, 1e-9);
  EXPECT_NEAR(last("platform").p_camera_body_m[0], -1.0, 1e-6);
}

TEST_F(QualisysPair, NeverHoldsThePoseOfAnOccludedBody) {
  run(1s);
  ASSERT_TRUE(device.set_fault("occlude:LOAD", true));
  run(20ms);
  EXPECT_FALSE(last("load").tracked);
  EXPECT_EQ(last("load").p_camera_body_m, (std::array<double, 3>{}));
  EXPECT_TRUE(last("platform").tracked);
  ASSERT_TRUE(device.set_fault("occlude:load", false));
  ASSERT_TRUE(device.set_fault("occlude", true));
  run(20ms);
  EXPECT_FALSE(last("load").tracked);
  EXPECT_FALSE(last("platform").tracked);
  EXPECT_EQ(driver.state(), State::streaming);
  ASSERT_TRUE(device.set_fault("occlude", false));
  run(20ms);
  EXPECT_TRUE(last("load").tracked);
}

TEST_F(QualisysPair, IdlesThroughTheEndOfAMeasurementAndFollowsTheNext) {
  run(1s);
  ASSERT_TRUE(device.set_fault("stop_measurement", true));
  run(20ms);
  EXPECT_EQ(driver.state(), State::idle);
  EXPECT_FALSE(last("load").tracked);
  EXPECT_THAT(std::string{driver.health().advice()}, HasSubstr("does not measure"));
  run(10s);
  EXPECT_EQ(driver.state(), State::idle);
  const std::size_t before = samples.size();
  ASSERT_TRUE(device.set_fault("stop_measurement", false));
  run(100ms);
  EXPECT_EQ(driver.state(), State::streaming);
  EXPECT_GT(samples.size(), before);
  EXPECT_TRUE(last("load").tracked);
  EXPECT_EQ(driver.health().reconnects(), 0u);
  const topic::Bodies& load = last("load");
  EXPECT_NEAR(load.p_camera_body_m[0], swing_m(from_ns(load.t_measured_ns)), 0.0002)
      << "time is mapped afresh";
}

TEST_F(QualisysPair, ConnectsWhileNothingIsMeasured) {
  ASSERT_TRUE(device.set_fault("stop_measurement", true));
  run(5s);
  EXPECT_EQ(driver.state(), State::idle);
  EXPECT_TRUE(samples.empty());
  ASSERT_TRUE(device.set_fault("stop_measurement", false));
  run(100ms);
  EXPECT_TRUE(last("load").tracked);
}

TEST_F(QualisysPair, NoticesASilentServerAndComesBack) {
  run(1s);
  ASSERT_TRUE(device.set_fault("silent", true));
  run(40ms);
  EXPECT_FALSE(last("load").tracked);
  EXPECT_EQ(driver.state(), State::streaming);
  run(3s);
  EXPECT_EQ(driver.state(), State::down);
  EXPECT_EQ(driver.health().phase(), LinkPhase::down);
  run(20s);
  ASSERT_TRUE(device.set_fault("silent", false));
  run(8s);
  EXPECT_EQ(driver.state(), State::streaming);
  EXPECT_TRUE(last("load").tracked);
  EXPECT_GE(driver.health().reconnects(), 1u);
  EXPECT_EQ(device.clients(), 1u) << "connections that were given up are gone";
}

TEST_F(QualisysPair, AsksForTheStreamAgainWhenOnlyDatagramsAreMissing) {
  run(1s);
  network.set_datagram_fault(kStream, {.silent = true});
  run(5s);
  EXPECT_EQ(driver.state(), State::streaming);
  EXPECT_THAT(std::string{driver.health().advice()}, HasSubstr("firewall"));
  EXPECT_FALSE(last("load").tracked);
  network.set_datagram_fault(kStream, {});
  run(100ms);
  EXPECT_TRUE(last("load").tracked);
  EXPECT_EQ(driver.health().advice(), "");
  EXPECT_EQ(driver.health().reconnects(), 0u);
}

TEST_F(QualisysPair, ConnectsAgainWhenTheServerClosesInTheMiddleOfAPacket) {
  run(1s);
  ASSERT_TRUE(device.set_fault("close_mid_frame", true));
  run(200ms);
  EXPECT_EQ(driver.state(), State::down);
  EXPECT_FALSE(last("load").tracked);
  EXPECT_EQ(rejected(Reason::transport), 1u);
  run(1s);
  EXPECT_EQ(driver.state(), State::streaming);
  EXPECT_TRUE(last("load").tracked);
  EXPECT_EQ(driver.health().reconnects(), 1u);
}

TEST_F(QualisysPair, WaitsLongerAndLongerForAServerThatIsNotThere) {
  network.set_stream_fault(kControl, {.refuse = true});
  run(12s);
  EXPECT_EQ(driver.state(), State::down);
  // Attempts at 0, 0.5, 1.5, 3.5, 7.5 s; the next at 12.5 s.
  EXPECT_EQ(rejected(Reason::transport), 5u);
  EXPECT_THAT(std::string{driver.health().advice()}, HasSubstr("cannot be reached"));
  network.set_stream_fault(kControl, {});
  run(1s);
  EXPECT_EQ(driver.state(), State::streaming);
}

TEST_F(QualisysPair, UnderstandsAStreamThatArrivesByteByByte) {
  network.set_stream_fault(kControl, {.chunk_bytes = 1});
  run(1s);
  EXPECT_EQ(driver.state(), State::streaming);
  EXPECT_TRUE(last("load").tracked);
}

TEST_F(QualisysPair, FollowsTimeStampsThatStartAgainUnannounced) {
  run(3s);
  ASSERT_TRUE(device.set_fault("restart_timestamp", true));
  run(200ms);
  EXPECT_TRUE(last("load").tracked);
  EXPECT_EQ(rejected(Reason::out_of_order), 1u);
  EXPECT_NEAR(last("load").p_camera_body_m[0], swing_m(from_ns(last("load").t_measured_ns)), 0.0002);
}

TEST_F(QualisysPair, DoesNotNeedTheFrameNumber) {
  ASSERT_TRUE(device.set_fault("stuck_frame_number", true));
  run(1s);
  EXPECT_EQ(last("load").frame_number, 1u);
  EXPECT_TRUE(last("load").tracked);
  EXPECT_GT(driver.health().received(), 180u);
  EXPECT_EQ(driver.health().lost(), 0u);
}

TEST_F(QualisysPair, TakesNothingFromAnotherAddress) {
  const auto stranger = network.datagram({0x7f000002, 41000});
  run(1s);
  const auto before = samples.size();
  DataFrame frame;
  frame.timestamp_us = 500'000'000;
  frame.bodies.size = 2;
  frame.bodies.all[0] = frame.bodies.all[1] = {true, {9, 9, 9}, {1, 0, 0, 0}, 0.0};
  std::array<std::uint8_t, 256> buffer{};
  exposing = false;
  run(20ms);
  samples.clear();
  ASSERT_TRUE(stranger->send(kStream, *encode_data(frame, {Component::bodies_res}, buffer)));
  run(2ms);
  EXPECT_GT(before, 0u);
  EXPECT_EQ(rejected(Reason::foreign), 1u);
  EXPECT_EQ(tracked(), 0u);
}

TEST_F(QualisysPair, NeverMixesUpBodiesWhenTheListChanges) {
  run(2s);
  for (const double silently : {0.0, 1.0}) {
    ASSERT_TRUE(device.set_fault("body_list_change", true, silently));
    run(2s);
    EXPECT_TRUE(last("load").tracked);
    ASSERT_TRUE(device.set_fault("body_list_change", false, silently));
    run(2s);
    EXPECT_TRUE(last("load").tracked);
  }
  EXPECT_GT(rejected(Reason::bad_value), 0u) << "the number of bodies gave the silent change away";
  for (const topic::Bodies& sample : samples) {
    if (!sample.tracked) continue;
    EXPECT_NEAR(sample.p_camera_body_m[2], sample.body.view() == "load" ? 3.0 : 0.5, 1e-6);
  }
  EXPECT_EQ(driver.health().reconnects(), 0u);
}

TEST_F(QualisysPair, StampsNeverGoBackThroughAnyOfThis) {
  for (const char* fault :
       {"slow", "delayed", "intermittent", "garbage", "off", "stop_measurement", "calibrate", "restart",
        "restart_timestamp", "body_list_change", "split_frame", "skip_frames", "oversize"}) {
    run(600ms);
    ASSERT_TRUE(device.set_fault(fault, true, 0.0));
    run(600ms);
    ASSERT_TRUE(device.set_fault(fault, false));
  }
  run(1s);
  std::int64_t t_ns = 0;
  std::uint64_t number = 0;
  for (const topic::Bodies& sample : samples) {
    if (sample.body.view() != "load") continue;
    EXPECT_GE(sample.t_measured_ns, t_ns);
    EXPECT_LE(sample.t_measured_ns, sample.t_received_ns);
    EXPECT_EQ(sample.sequence_number, ++number);
    t_ns = sample.t_measured_ns;
  }
}

TEST_F(QualisysPair, IsRefusedWhenTheServerIsFullAndGetsInLater) {
  DeviceConfig full = device_config();
  full.max_clients = 0;
  QualisysDevice crowded{full, *server, *qtm_udp};
  server->on_event(&crowded);
  for (int i = 0; i < 300; ++i) {
    network.run_until(clock.now() + 1ms);
    crowded.step(clock.now());
    driver.step(clock.now());
  }
  EXPECT_EQ(driver.state(), State::down);
  EXPECT_EQ(rejected(Reason::refused), 1u);
  EXPECT_THAT(std::string{driver.health().advice()}, HasSubstr("too many clients"));
  server->on_event(&device);
  run(1s);
  EXPECT_EQ(driver.state(), State::streaming);
}

}  // namespace
}  // namespace motionlab::qualisys
