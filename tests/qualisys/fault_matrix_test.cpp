// Driver and simulated server joined in memory, over every fault that the device has: what health says, what
// the samples are worth, how the driver reacts, and that all is well again when the fault has ended.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
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
constexpr Nanoseconds kPeriod = 5ms;
/// Roll 10, pitch 20, yaw 30 deg: askew enough for every definition of angles to differ.
constexpr std::array<double, 4> kTilted{0.943714364147489, 0.127679440695781, 0.144878125417369,
                                        0.268535822751569};

/// What a fault of 4 s does. What is empty is as without the fault.
struct Cell {
  const char* fault;
  double value = 0.0;
  // Quality: shares of what a healthy device gives.
  double told_min = 0.97, told_max = 1.03;  ///< samples of the load that are tracked
  double wrong_m = 0.0;                     ///< by how much its position is off
  std::optional<double> age_s{};            ///< of samples, from exposure to arrival
  // Reaction and health.
  std::optional<State> state{};  ///< at the end of the fault; empty: streaming
  std::optional<Reason> reason{};
  bool reconnects = false;
  const char* advice = "";  ///< part of it, at the end of the fault
};
void PrintTo(const Cell& cell, std::ostream* out) {
  *out << cell.fault;
}

class QualisysBench : public testing::Test {
 protected:
  QualisysBench() {
    server->on_event(&device);
    client->on_event(&driver);
    stream->on_datagram([this](Bytes b, Endpoint from, LabTime t) { driver.on_datagram(b, from, t); });
  }

  static double x_m(LabTime t) { return 0.5 * std::sin(2.0 * seconds(t.time_since_epoch())); }

  void run(Nanoseconds duration) {
    for (const LabTime end = clock.now() + duration; clock.now() < end;) {
      network.run_until(clock.now() + 1ms);
      const LabTime now = clock.now();
      if (now.time_since_epoch() % kPeriod == 0ns) {
        CameraFrame frame;
        frame.bodies.push_back({"load", true, {x_m(now), 2.0, 3.0}, kTilted, 0.0004});
        frame.unlabelled = {
            {{1.0, 1.0, 2.0}, 7, 0.0}, {{1.0, 1.062, 2.0}, 8, 0.0}, {{5.0, 5.0, 5.0}, 9, 0.0}};
        device.capture(frame, now);
      }
      device.step(now);
      driver.step(now);
    }
  }

  /// How a stretch of time went, for the load.
  struct Stretch {
    double tracked = 0.0;  ///< share of the exposures
    double wrong_m = 0.0;  ///< greatest error of a tracked position
    double age_s = 0.0;    ///< mean
    bool hook = false;     ///< tracked at the end
    std::size_t told = 0;
  };
  Stretch stretch(Nanoseconds duration) {
    samples.clear();
    run(duration);
    Stretch s;
    for (const topic::Bodies& sample : samples) {
      if (sample.body.view() == "hook") s.hook = sample.tracked;
      if (sample.body.view() != "load") continue;
      ++s.told;
      if (!sample.tracked) {
        EXPECT_EQ(sample.p_camera_body_m, (std::array<double, 3>{})) << "no pose is held";
        continue;
      }
      s.tracked += 1.0;
      s.age_s += 1e-9 * static_cast<double>(sample.t_received_ns - sample.t_measured_ns);
      s.wrong_m = std::max(s.wrong_m, std::abs(sample.p_camera_body_m[1] - 2.0));
    }
    if (s.tracked > 0.0) s.age_s /= s.tracked;
    s.tracked /= seconds(duration) / seconds(kPeriod);
    return s;
  }
  [[nodiscard]] std::vector<std::uint64_t> rejects() const {
    std::vector<std::uint64_t> all;
    for (std::size_t r = 0; r < kReasonCount; ++r)
      all.push_back(driver.health().rejected(static_cast<Reason>(r)));
    return all;
  }

  static DriverConfig driver_config() {
    DriverConfig c;
    c.bodies = {"load"};
    c.hook.name = "hook";
    c.server_address = kStream.address;
    c.udp_port = kStream.port;
    return c;
  }

  SteppedClock clock;
  MemoryNetwork network{clock, {.latency = 100us}};
  std::unique_ptr<StreamServer> server = network.server(kControl);
  std::unique_ptr<DatagramSocket> qtm_udp = network.datagram(kQtmUdp);
  std::unique_ptr<StreamClient> client = network.client(kControl);
  std::unique_ptr<DatagramSocket> stream = network.datagram(kStream);
  std::vector<topic::Bodies> samples;
  QualisysDevice device{{}, *server, *qtm_udp};
  QualisysDriver driver{driver_config(), *client, [this](const topic::Bodies& s) { samples.push_back(s); }};
};

class QualisysFaults : public QualisysBench, public testing::WithParamInterface<Cell> {};

TEST_P(QualisysFaults, IsNoticedAnsweredAndEnds) {
  const Cell& cell = GetParam();
  run(2s);
  const Stretch before = stretch(2s);
  ASSERT_NEAR(before.tracked, 1.0, 0.02);
  ASSERT_TRUE(before.hook);
  ASSERT_EQ(driver.health().rejected_total(), 0u);
  ASSERT_EQ(driver.health().advice(), "");

  const auto rejects_before = rejects();
  ASSERT_TRUE(device.set_fault(cell.fault, true, cell.value));
  const Stretch during = stretch(4s);
  EXPECT_GE(during.tracked, cell.told_min);
  EXPECT_LE(during.tracked, cell.told_max);
  if (during.tracked > 0.0) {
    EXPECT_NEAR(during.wrong_m, cell.wrong_m, 1e-5);
    EXPECT_NEAR(during.age_s, cell.age_s.value_or(0.0071), 0.0015);
  }
  EXPECT_EQ(driver.state(), cell.state.value_or(State::streaming));
  EXPECT_THAT(std::string{driver.health().advice()}, HasSubstr(cell.advice));
  if (*cell.advice == '\0') {
    EXPECT_EQ(driver.health().advice(), "");
  }
  const auto rejects_during = rejects();
  for (std::size_t r = 0; r < kReasonCount; ++r) {
    const auto reason = static_cast<Reason>(r);
    if (cell.reason == reason) {
      EXPECT_GT(rejects_during[r], rejects_before[r]) << to_string(reason);
    } else if (!cell.reconnects) {
      EXPECT_EQ(rejects_during[r], rejects_before[r]) << to_string(reason);
    }
  }
  EXPECT_EQ(driver.health().phase() == LinkPhase::up,
            !cell.state || *cell.state == State::streaming || *cell.state == State::idle);

  ASSERT_TRUE(device.set_fault(cell.fault, false));
  run(9s);  // the longest pause between attempts is 5 s
  EXPECT_EQ(driver.health().reconnects() > 0, cell.reconnects);
  const Stretch after = stretch(2s);
  EXPECT_NEAR(after.tracked, 1.0, 0.02);
  EXPECT_NEAR(after.wrong_m, 0.0, 1e-5);
  EXPECT_NEAR(after.age_s, 0.0071, 0.0005);
  EXPECT_TRUE(after.hook);
  EXPECT_EQ(driver.state(), State::streaming);
  EXPECT_EQ(driver.health().phase(), LinkPhase::up);
  EXPECT_EQ(driver.health().advice(), "");
  EXPECT_EQ(device.clients(), 1u) << "connections that were given up are gone";
}

// Common to all devices. `off` and `garbage` end the connection; nothing of them may look like a body.
INSTANTIATE_TEST_SUITE_P(
    Common, QualisysFaults,
    testing::Values(Cell{"off", 0, 0, 0.02, 0, {}, State::welcome, Reason::transport, true, "QTM"},
                    Cell{"stuck"},
                    Cell{"garbage", 0, 0, 0.02, 0, {}, State::down, Reason::too_short, true, "not QTM's"},
                    Cell{"wrong", 0.25, 0.97, 1.03, 0.25}, Cell{"slow", 4, 0.24, 0.26},
                    Cell{"delayed", 0.05, 0.97, 1.03, 0, 0.0571}, Cell{"intermittent", 0.5, 0.45, 0.55}),
    [](const auto& test) { return std::string{test.param.fault}; });

INSTANTIATE_TEST_SUITE_P(
    OfTheDevice, QualisysFaults,
    testing::Values(
        Cell{"silent", 0, 0, 0.01, 0, {}, State::welcome, Reason::transport, true, "GetState"},
        Cell{"occlude", 0, 0, 0.01}, Cell{"occlude:LOAD", 0, 0, 0.01}, Cell{"residual"}, Cell{"drop_rate"},
        Cell{"out_of_sync"}, Cell{"skip_frames", 4, 0.24, 0.26},
        Cell{"stop_measurement", 0, 0, 0.01, 0, {}, State::idle, {}, false, "does not measure"},
        Cell{"calibrate", 0, 0, 0.01, 0, {}, State::idle, {}, false, "does not measure"},
        Cell{"restart", 0, 0, 0.01, 0, {}, State::down, Reason::transport, true, "QTM"},
        Cell{.fault = "restart_timestamp", .reason = Reason::out_of_order}, Cell{"stuck_frame_number"},
        Cell{"close_mid_frame", 0, 0.8, 0.95, 0, {}, {}, Reason::transport, true}, Cell{"no_state"},
        Cell{.fault = "half_open", .told_min = 0.97}, Cell{"split_header"}, Cell{"split_frame"},
        Cell{"oversize", 0, 0, 0.01, 0, {}, {}, Reason::too_long, false, "firewall"},
        Cell{"old_version", 20, 0, 0.1, 0, {}, State::down, Reason::refused, true, "1.25 to 1.21"},
        Cell{.fault = "old_version",
             .value = 22,
             .told_min = 0.8,
             .told_max = 0.95,
             .reason = Reason::transport,
             .reconnects = true},
        Cell{.fault = "body_list_change", .told_min = 0.95, .reason = Reason::bad_value},
        Cell{.fault = "body_list_change", .value = 1.0, .told_min = 0.95, .reason = Reason::bad_value}),
    [](const auto& test) {
      std::string name = test.param.fault;
      std::replace(name.begin(), name.end(), ':', '_');
      return name + (test.param.value > 0.0 ? "_" + std::to_string(static_cast<int>(test.param.value)) : "");
    });

/// Orientation is checked once per connection, so these faults show when the driver connects under them.
class QualisysOrientation : public QualisysBench, public testing::WithParamInterface<Cell> {};

TEST_P(QualisysOrientation, IsCheckedAgainstTheAnglesAndDisagreementIsSaid) {
  const Cell& cell = GetParam();
  run(2s);
  EXPECT_EQ(driver.orientation(), OrientationCheck::Verdict::agree);
  ASSERT_TRUE(device.set_fault(cell.fault, true));
  ASSERT_TRUE(device.set_fault("close_mid_frame", true));
  run(3s);
  EXPECT_EQ(driver.state(), State::streaming);
  EXPECT_THAT(std::string{driver.health().advice()}, HasSubstr(cell.advice));
  EXPECT_THAT(std::string{driver.health().advice()}, HasSubstr("matrix and Euler angles disagree"));
  ASSERT_TRUE(device.set_fault(cell.fault, false));
  ASSERT_TRUE(device.set_fault("close_mid_frame", false));
  ASSERT_TRUE(device.set_fault("close_mid_frame", true));
  run(3s);
  EXPECT_EQ(driver.orientation(), OrientationCheck::Verdict::agree);
  EXPECT_EQ(driver.health().advice(), "");
}

INSTANTIATE_TEST_SUITE_P(OfTheDevice, QualisysOrientation,
                         testing::Values(Cell{.fault = "matrix_by_rows", .advice = "by rows"},
                                         Cell{.fault = "other_angles", .advice = "Qualisys standard"}),
                         [](const auto& test) { return std::string{test.param.fault}; });

TEST_F(QualisysBench, TellsWhatTheCamerasSayOfThemselves) {
  run(2s);
  ASSERT_TRUE(device.set_fault("residual", true, 0.003));
  ASSERT_TRUE(device.set_fault("drop_rate", true, 0.25));
  ASSERT_TRUE(device.set_fault("out_of_sync", true, 0.125));
  run(100ms);
  const auto load = std::find_if(samples.rbegin(), samples.rend(),
                                 [](const topic::Bodies& s) { return s.body.view() == "load"; });
  EXPECT_NEAR(load->residual_m, 0.0034, 1e-8);
  EXPECT_NEAR(load->drop_rate, 0.25, 1e-9);
  EXPECT_NEAR(load->out_of_sync_rate, 0.125, 1e-9);
}

}  // namespace
}  // namespace motionlab::qualisys
