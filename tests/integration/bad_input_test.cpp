// Whatever arrives that is not a device's word is counted, and no command changes because of it.
#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "drivers/core/random.hpp"
#include "drivers/mru/mru_wire.hpp"
#include "drivers/qualisys/qualisys_wire.hpp"
#include "tests/integration/line.hpp"

namespace motionlab::integration {
namespace {

using topic::ModeState;

constexpr double kFrom_s = 20;
constexpr double kTo_s = 24;
const Endpoint kForeigner = Endpoint::parse("10.9.8.7:40000");
const Endpoint kNeighbour = Endpoint::parse("127.0.0.1:40001");

/// Every UDP port of the gateway, and the port of the device behind it.
struct Port {
  std::string device;
  Endpoint at;
};
std::vector<Port> ports(const service::GatewayConfig& gateway) {
  return {{"mru1", gateway.mrus[0].listen},
          {"mru2", gateway.mrus[1].listen},
          {"qualisys", gateway.qualisys.listen},
          {"arm", gateway.comau.listen}};
}

/// A run engaged at 10 s; `disturb` is called before each step from 20 to 24 s.
struct Record {
  std::uint64_t commands = 0;
  ModeState mode{};
  std::vector<topic::Health> before, after;

  [[nodiscard]] std::uint64_t rejected(std::string_view device, Reason reason) const {
    const auto i = static_cast<std::size_t>(reason);
    return of(after, device).rejected[i] - of(before, device).rejected[i];
  }
  [[nodiscard]] static const topic::Health& of(const std::vector<topic::Health>& all,
                                               std::string_view device) {
    return *std::find_if(all.begin(), all.end(), [&](const auto& h) { return h.device.view() == device; });
  }
};

using Disturbance = std::function<void(Line&, DatagramSocket& foreigner, DatagramSocket& neighbour)>;

std::vector<topic::Health> healths(Line& line) {
  std::vector<topic::Health> all;
  for (const char* const device : {"mru1", "mru2", "qualisys", "arm", "winch"}) {
    all.push_back(line.health(device));
  }
  return all;
}

Record run(const Disturbance& disturb) {
  Line line(configure("thesis-wave"));
  const auto foreigner = line.network().datagram(kForeigner);
  const auto neighbour = line.network().datagram(kNeighbour);
  line.engage_and_run_to(kFrom_s);
  Record result;
  result.before = healths(line);
  while (line.now_s() < kTo_s - 1e-9) {
    if (disturb) disturb(line, *foreigner, *neighbour);
    line.step();
  }
  line.run_for(1);
  result.after = healths(line);
  result.commands = line.commands_hash();
  result.mode = line.mode().state;
  return result;
}

/// The same run with nobody disturbing.
const Record& undisturbed() {
  static const Record run_once = run({});
  return run_once;
}

ByteBuffer bytes(std::size_t size, std::uint8_t value) {
  return ByteBuffer(size, value);
}

class BadInput : public testing::Test {
 protected:
  void SetUp() override { ASSERT_EQ(undisturbed().mode, ModeState::engaged); }
  static void expect_same(const Record& got) {
    EXPECT_EQ(got.mode, ModeState::engaged);
    EXPECT_EQ(got.commands, undisturbed().commands) << "a command has changed";
  }
};

TEST_F(BadInput, ForeignersAreCountedOnEveryPort) {
  const Record got = run([](Line& line, DatagramSocket& foreigner, DatagramSocket&) {
    for (const auto& port : ports(line.config().gateway)) {
      (void)foreigner.send(port.at, bytes(100, 0x71));
      (void)foreigner.send(port.at, bytes(52, 0));
    }
  });
  expect_same(got);
  for (const char* const device : {"mru1", "mru2", "qualisys", "arm"}) {
    EXPECT_EQ(got.rejected(device, Reason::foreign), 8000U) << device;
  }
}

TEST_F(BadInput, TheRightHostAtAnotherPortIsForeignToTheArm) {
  const Record got = run([](Line& line, DatagramSocket&, DatagramSocket& neighbour) {
    (void)neighbour.send(line.config().gateway.comau.listen, bytes(52, 0));
  });
  expect_same(got);
  EXPECT_EQ(got.rejected("arm", Reason::foreign), 4000U);
}

TEST_F(BadInput, TruncatedAndOversizedDatagramsAreCounted) {
  const auto mru = [](std::uint8_t token, std::size_t size) {
    ByteBuffer datagram = bytes(size, 0);
    if (size > 0) datagram[0] = 0x71;
    if (size > 1) datagram[1] = 97;
    if (size > 2) datagram[2] = token;
    return datagram;
  };
  const Record got = run([&](Line& line, DatagramSocket&, DatagramSocket& neighbour) {
    const auto& gateway = line.config().gateway;
    for (const std::size_t size : {0, 1, 3, 99, 101, 200, 65507}) {
      (void)neighbour.send(gateway.mrus[0].listen, mru(11, size));
      (void)neighbour.send(gateway.mrus[1].listen, mru(12, size));
    }
    ByteBuffer frame = qualisys::encode_text(qualisys::PacketType::data, "0123456789");
    ByteBuffer longer = frame;
    longer.push_back(0);
    (void)neighbour.send(gateway.qualisys.listen, Bytes{frame}.first(7));
    (void)neighbour.send(gateway.qualisys.listen, Bytes{frame}.first(frame.size() - 1));
    (void)neighbour.send(gateway.qualisys.listen, longer);
    (void)neighbour.send(gateway.qualisys.listen, bytes(65507, 0xff));
  });
  expect_same(got);
  for (const char* const device : {"mru1", "mru2"}) {
    EXPECT_EQ(got.rejected(device, Reason::too_short), 16000U) << device;
    EXPECT_EQ(got.rejected(device, Reason::too_long), 12000U) << device;
  }
  EXPECT_GE(got.rejected("qualisys", Reason::too_short), 8000U);
  EXPECT_GE(got.rejected("qualisys", Reason::too_long), 4000U);
}

TEST_F(BadInput, NotANumberAnywhereInAnMruDatagramIsRefused) {
  mru::Layout layout;
  const Record got =
      run([&, which = std::size_t{0}](Line& line, DatagramSocket&, DatagramSocket& neighbour) mutable {
        mru::Frame frame;
        frame.size = layout.variables.size();
        // The first value is SystemTime, a whole number.
        const std::size_t at = 1 + which++ % (frame.size - 1);
        frame.values[0] = 1e3 * line.now_s() + 1;
        frame.values[at] = which % 2 == 0 ? std::numeric_limits<double>::quiet_NaN()
                                          : std::numeric_limits<double>::infinity();
        std::array<std::uint8_t, mru::kMaxDatagram> to{};
        const auto datagram = mru::encode(frame, layout, mru::ChecksumRule::ones_complement, to);
        ASSERT_TRUE(datagram);
        (void)neighbour.send(line.config().gateway.mrus[0].listen, *datagram);
      });
  expect_same(got);
  EXPECT_EQ(got.rejected("mru1", Reason::bad_value), 4000U);
}

TEST_F(BadInput, RepeatedAndOldMruDatagramsAreRefused) {
  mru::Layout layout;
  const Record got = run([&](Line& line, DatagramSocket&, DatagramSocket& neighbour) {
    mru::Frame frame;
    frame.size = layout.variables.size();
    frame.values[0] = 1e3 * line.now_s() - 500;
    std::array<std::uint8_t, mru::kMaxDatagram> to{};
    const auto datagram = mru::encode(frame, layout, mru::ChecksumRule::ones_complement, to);
    ASSERT_TRUE(datagram);
    (void)neighbour.send(line.config().gateway.mrus[0].listen, *datagram);
  });
  expect_same(got);
  EXPECT_EQ(got.rejected("mru1", Reason::out_of_order), 4000U);
}

TEST_F(BadInput, ADeviceThatSaysEverythingTwiceIsHeardOnce) {
  const Record got =
      run([](Line& line, DatagramSocket&, DatagramSocket&) { line.fault("mru1", "duplicate", true, 1); });
  expect_same(got);
  EXPECT_GE(got.rejected("mru1", Reason::duplicate), 950U);
}

TEST_F(BadInput, RandomBytesFromTheRightHostChangeNothing) {
  const Record got =
      run([random = Random(7)](Line& line, DatagramSocket&, DatagramSocket& neighbour) mutable {
        for (const auto& port : ports(line.config().gateway)) {
          ByteBuffer datagram(random.bits() % 300);
          for (auto& byte : datagram) byte = static_cast<std::uint8_t>(random.bits());
          (void)neighbour.send(port.at, datagram);
        }
      });
  expect_same(got);
}

TEST_F(BadInput, AFloodOfAMillionJunkDatagramsChangesNothing) {
  const ByteBuffer junk = bytes(100, 0xaa);
  const Record got = run([&](Line& line, DatagramSocket& foreigner, DatagramSocket& neighbour) {
    if (line.now_s() > 21) return;
    for (const auto& port : ports(line.config().gateway)) {
      for (int i = 0; i < 125; ++i) {
        (void)foreigner.send(port.at, junk);
        (void)neighbour.send(port.at, junk);
      }
    }
  });
  expect_same(got);
  for (const char* const device : {"mru1", "mru2", "qualisys"}) {
    EXPECT_GE(got.rejected(device, Reason::foreign), 125'000U) << device;
    EXPECT_GE(got.rejected(device, Reason::bad_header) + got.rejected(device, Reason::too_short) +
                  got.rejected(device, Reason::too_long),
              125'000U)
        << device;
  }
  EXPECT_GE(got.rejected("arm", Reason::foreign), 250'000U);
}

/// A device that spoils its own datagrams now and then; the rest is good.
struct Spoiled {
  std::string device, fault;
  Reason reason;
  double value = 0;
};
void PrintTo(const Spoiled& spoiled, std::ostream* out) {
  *out << spoiled.device << "_" << spoiled.fault;
}

class SpoiledDatagrams : public testing::TestWithParam<Spoiled> {};

TEST_P(SpoiledDatagrams, AreCountedAndMissedLikeLostOnes) {
  const Spoiled& spoiled = GetParam();
  const lockstep::Config config = configure("thesis-wave");
  Line line(config);
  line.engage_and_run_to(kFrom_s);
  const auto before = line.rejected(spoiled.device, spoiled.reason);
  line.take_motion();
  // One good datagram in between: three of four are spoiled.
  for (int i = 0; line.now_s() < 30; ++i) {
    line.fault(spoiled.device, spoiled.fault, i % 4 != 3, spoiled.value);
    line.run_for(0.005);
  }
  EXPECT_EQ(line.mode().state, ModeState::engaged) << line.mode().reason.view();
  const auto motion = line.take_motion();
  EXPECT_LE(motion.swing_rms_deg, 0.3);
  EXPECT_GT(line.rejected(spoiled.device, spoiled.reason) - before, 1000U);
  EXPECT_EQ(steps_beyond_limits(line.steps(), config.gateway.limits, config.gateway.control_period_s), 0U);
}

INSTANTIATE_TEST_SUITE_P(OfADevice, SpoiledDatagrams,
                         testing::Values(Spoiled{"mru1", "truncate", Reason::too_short, 1},
                                         Spoiled{"mru1", "oversize", Reason::too_long},
                                         Spoiled{"mru1", "nan", Reason::bad_value},
                                         Spoiled{"mru1", "wrong_token", Reason::bad_header},
                                         Spoiled{"arm", "wrong_size", Reason::too_short, -1},
                                         Spoiled{"arm", "wrong_size", Reason::too_long, 1},
                                         Spoiled{"arm", "nan_answer", Reason::bad_value},
                                         Spoiled{"qualisys", "truncate", Reason::too_short, 1},
                                         Spoiled{"qualisys", "oversize", Reason::too_long},
                                         Spoiled{"qualisys", "foreign", Reason::foreign, 1}),
                         [](const auto& test) {
                           return test.param.device + "_" + test.param.fault + "_" +
                                  std::string(to_string(test.param.reason));
                         });

TEST(CorruptedDatagrams, OfTheUnitAreRefusedOnceItsRuleIsKnownAndPolicySaysSo) {
  lockstep::Config config = configure("thesis-wave");
  config.gateway.mrus.front().driver.checksum.policy = mru::ChecksumPolicy::enforce;
  Line line(config);
  line.engage_and_run_to(kFrom_s);
  line.fault("mru1", "corrupt", true, 0.05);
  line.take_motion();
  line.run_for(20);
  EXPECT_EQ(line.mode().state, ModeState::engaged) << line.mode().reason.view();
  EXPECT_LE(line.take_motion().swing_rms_deg, 0.3);
  EXPECT_GT(line.rejected("mru1", Reason::bad_checksum) + line.rejected("mru1", Reason::bad_header) +
                line.rejected("mru1", Reason::bad_value),
            100U);
}

// With the policy "count" they come through marked as suspect; the estimator's gate stands behind.
TEST(CorruptedDatagrams, OfTheUnitAreSurvivedWhenTheyAreOnlyCounted) {
  const lockstep::Config config = configure("thesis-wave");
  Line line(config);
  line.engage_and_run_to(kFrom_s);
  line.fault("mru1", "corrupt", true, 0.05);
  line.take_motion();
  line.run_for(20);
  EXPECT_EQ(line.mode().state, ModeState::engaged) << line.mode().reason.view();
  EXPECT_LE(line.take_motion().swing_rms_deg, 0.3);
  EXPECT_EQ(steps_beyond_limits(line.steps(), config.gateway.limits, config.gateway.control_period_s), 0U);
  for (const Step& step : line.steps()) ASSERT_TRUE(step.finite());
}

TEST(MidFrame, ACameraServerThatEndsInTheMiddleOfAPacketIsCalledAgain) {
  Line line(configure("thesis-wave"));
  line.engage_and_run_to(kFrom_s);
  const auto reconnects = line.health("qualisys").reconnects;
  line.take_motion();
  line.fault("qualisys", "close_mid_frame", true);
  line.run_for(5);
  EXPECT_EQ(line.mode().state, ModeState::engaged) << line.mode().reason.view();
  EXPECT_LE(line.take_motion().load_error_max_m, 0.05);
  EXPECT_EQ(line.health("qualisys").reconnects, reconnects + 1);
  EXPECT_EQ(line.health("qualisys").link, topic::LinkState::up);
  EXPECT_GE(line.rejected("qualisys", Reason::transport), 1U);
}

TEST(MidFrame, AWinchControllerThatEndsInTheMiddleOfAFrameIsADeviceThatWasLost) {
  const lockstep::Config config = configure("thesis-wave");
  Line line(config);
  line.engage_and_run_to(kFrom_s);
  const auto reconnects = line.health("winch").reconnects;
  line.fault("winch", "close_mid_frame", true);
  line.run_for(5);
  EXPECT_EQ(line.health("winch").reconnects, reconnects + 1);
  EXPECT_EQ(line.health("winch").link, topic::LinkState::up);
  EXPECT_EQ(line.mode().state, ModeState::fault);
  EXPECT_EQ(line.mode().fault_code.view(), "winch_stale");
  EXPECT_EQ(steps_beyond_limits(line.steps(), config.gateway.limits, config.gateway.control_period_s), 0U);
  EXPECT_TRUE(line.steps().back().at_rest());
}

}  // namespace
}  // namespace motionlab::integration
