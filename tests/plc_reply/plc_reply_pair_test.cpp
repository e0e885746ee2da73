// Driver and simulated PLC together: what comes through, and who has control.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>
#include <string>

#include "tests/plc_reply/plc_reply_frames.hpp"
#include "tests/plc_reply/plc_reply_pair.hpp"
#include "tests/support/allocations.hpp"

namespace motionlab::plc_reply {
namespace {

using testing::HasSubstr;

TEST(PlcReplyPair, TellsBothPlatformsAndBothUnitsTwoHundredTimesASecond) {
  PlcPair pair;
  pair.run(2s);
  const LinkHealth& health = pair.driver.health();
  EXPECT_EQ(health.phase(), LinkPhase::up);
  EXPECT_TRUE(health.advice().empty()) << health.advice();
  EXPECT_NEAR(health.rate_hz(pair.clock.now()), 200.0, 1.0);
  EXPECT_EQ(health.rejected_total(), 0U);
  EXPECT_EQ(health.lost(), 0U);
  EXPECT_NEAR(static_cast<double>(pair.bodies.size()), 800.0, 8.0);
  EXPECT_NEAR(static_cast<double>(pair.units.size()), 800.0, 8.0);
  EXPECT_EQ(pair.device.health().rejected_total(), 0U);
  EXPECT_EQ(pair.device.sent(), pair.driver.sent()) << "one reply for each request";
}

TEST(PlcReplyPair, TellsWhereAPlatformWasWhenItSaysItWasThere) {
  PlcPair pair;
  pair.run(2s);
  for (std::size_t ship = 0; ship < 2; ++ship) {
    const topic::Bodies& body = pair.bodies[pair.bodies.size() - 2 + ship];
    EXPECT_EQ(body.device.view(), "plc");
    EXPECT_EQ(body.body.view(), ship == 0 ? "em8000" : "em1500");
    EXPECT_TRUE(body.tracked);
    EXPECT_TRUE(std::isnan(body.residual_m));
    // The reply's way through the memory network is younger than the cycle that its latency stands for.
    const Six eta = PlcPair::platform_at(ship, from_ns(body.t_measured_ns) - 100us).eta;
    for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(body.p_camera_body_m[i], eta[i], 1e-7);
    const auto q = quaternion(eta[3], eta[4], eta[5], EulerOrder::xyz);
    for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(body.q_camera_body[i], q[i], 1e-8);
  }
}

TEST(PlcReplyPair, TellsTwelveValuesOfAUnitAndNeverThatItIsStable) {
  PlcPair pair;
  pair.run(1s);
  const topic::Mru& unit = pair.units.back();
  EXPECT_EQ(unit.device.view(), "plc_mru2");
  EXPECT_FALSE(unit.stable);
  EXPECT_NEAR(unit.p_heading_origin_m[1], 0.02, 1e-7);
  EXPECT_NEAR(unit.euler_heading_mru_rad[2], 0.06, 1e-7);
  EXPECT_NEAR(unit.v_heading_origin_mps[2], 0.3, 1e-7);
  EXPECT_NEAR(unit.omega_mru_radps[1], 0.5, 1e-7);
  for (const double missing : {unit.omega_down_radps, unit.v_mru_mps[0], unit.a_mru_mps2[1],
                               unit.a_heading_origin_mps2[2], unit.sensor_temperature_degc}) {
    EXPECT_TRUE(std::isnan(missing));
  }
  EXPECT_EQ(unit.t_received_ns - unit.t_measured_ns, 10'000'000);
}

TEST(PlcReplyPair, EulerAnglesBuildTheTurnOfEitherOrder) {
  constexpr double kHalfRoot = 0.7071067811865476;
  // A quarter turn about x, then one about the new z; and the other way round.
  const auto xyz = quaternion(std::numbers::pi / 2, 0.0, std::numbers::pi / 2, EulerOrder::xyz);
  const auto zyx = quaternion(std::numbers::pi / 2, 0.0, std::numbers::pi / 2, EulerOrder::zyx);
  const std::array<double, 4> expected_xyz{0.5, 0.5, -0.5, 0.5}, expected_zyx{0.5, 0.5, 0.5, 0.5};
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(xyz[i], expected_xyz[i], 1e-15);
    EXPECT_NEAR(zyx[i], expected_zyx[i], 1e-15);
  }
  EXPECT_NEAR(quaternion(0.0, std::numbers::pi / 2, 0.0, EulerOrder::xyz)[2], kHalfRoot, 1e-15);
}

TEST(PlcReplyPair, SaysWhichUnitThePlcDoesNotHear) {
  PlcPair pair;
  pair.heard[1] = false;
  pair.run(1s);
  EXPECT_THAT(std::string(pair.driver.health().advice()), HasSubstr("mru2"));
  EXPECT_EQ(pair.driver.health().phase(), LinkPhase::up);
  for (const topic::Mru& unit : pair.units)
    EXPECT_EQ(unit.device.view(), "plc_mru1") << "zeros are no motion";
  pair.heard = {false, true};
  pair.units.clear();
  pair.run(1s);
  EXPECT_THAT(std::string(pair.driver.health().advice()), HasSubstr("mru1"));
  EXPECT_EQ(pair.units.back().device.view(), "plc_mru2");
}

TEST(PlcReplyPair, CountsRepliesThatNeverCame) {
  PlcPair pair;
  pair.run(1s);
  ASSERT_TRUE(pair.fault("silent", true));
  pair.run(1s);
  ASSERT_TRUE(pair.fault("silent", false));
  pair.run(100ms);
  EXPECT_NEAR(static_cast<double>(pair.driver.health().lost()), 200.0, 3.0);
}

TEST(PlcReplyPair, SeesThatThePlcWasRestarted) {
  PlcPair pair;
  pair.run(1s);
  ASSERT_TRUE(pair.fault("off", true));
  pair.run(50ms);
  ASSERT_TRUE(pair.fault("off", false));
  pair.run(100ms);
  EXPECT_EQ(pair.driver.health().reconnects(), 1U);
  EXPECT_EQ(pair.driver.health().phase(), LinkPhase::up);
}

TEST(PlcReplyPair, TakesRepliesFromThePlcAlone) {
  PlcPair pair;
  pair.driver.step(pair.clock.now());
  for (const Endpoint stranger : {Endpoint{kPlc.address + 1, kPlc.port}, Endpoint{kPlc.address, 50051}}) {
    pair.driver.on_datagram(kReplyBytes, stranger, pair.clock.now());
  }
  EXPECT_EQ(pair.driver.health().rejected(Reason::foreign), 2U);
  EXPECT_TRUE(pair.bodies.empty());
  pair.driver.on_datagram(kReplyBytes, kPlc, pair.clock.now());
  EXPECT_EQ(pair.bodies.size(), 2U);
  pair.driver.on_datagram(kReplyBytes, kPlc, pair.clock.now());
  EXPECT_EQ(pair.bodies.size(), 2U) << "the same reply again says nothing";
  EXPECT_EQ(pair.driver.health().received(), 1U);
}

TEST(PlcReplyPair, AnswersNothingButARequestOfTheRightSize) {
  PlcPair pair;
  const auto ask = [&](std::size_t size) {
    pair.device.on_datagram(ByteBuffer(size, 0), kGateway, pair.clock.now());
  };
  for (const std::size_t size : {0U, 135U, 137U, 304U}) ask(size);
  pair.device.cycle(pair.clock.now(), {});
  EXPECT_EQ(pair.device.sent(), 0U);
  EXPECT_EQ(pair.device.health().rejected_total(), 4U);
  ask(136);
  ask(136);
  pair.device.cycle(pair.clock.now(), {});
  EXPECT_EQ(pair.device.sent(), 2U) << "one for each";
}

TEST(PlcReplyPair, GivesControlToTheKeyWithABeatingHeartAndTakesItBack) {
  PlcPair pair;  // it shows that `controlled` can be true
  auto request = kRequest;
  store<std::endian::little>(MutableBytes{request}.first(4), kControlKey);
  for (std::uint32_t beat = 1; beat <= 3; ++beat) {
    pair.device.on_datagram(request, kGateway, pair.clock.now());
    EXPECT_FALSE(pair.device.controlled(pair.clock.now())) << "the heart stands still";
  }
  store<std::endian::little>(MutableBytes{request}.subspan(4, 4), std::uint32_t{1});
  pair.device.on_datagram(request, kGateway, pair.clock.now());
  EXPECT_TRUE(pair.device.controlled(pair.clock.now()));
  pair.run(499ms);
  EXPECT_TRUE(pair.device.controlled(pair.clock.now()));
  pair.run(1ms);
  EXPECT_FALSE(pair.device.controlled(pair.clock.now())) << "our own requests do not prolong it";
}

TEST(PlcReplyPair, RefusesAFaultThatItDoesNotHaveAndNamesThoseItHas) {
  PlcPair pair;
  const Status refused = pair.device.set_fault("checksum", true);
  ASSERT_FALSE(refused);
  EXPECT_THAT(std::string(refused.fault().text), HasSubstr("stuck garbage"));
}

TEST(PlcReplyPair, TheDriverTakesNothingFromTheHeap) {
  class Nowhere final : public DatagramOut {
   public:
    Status send(Endpoint, Bytes) override { return Done{}; }
  } nowhere;
  std::size_t told = 0;
  PlcReplyDriver driver{PlcPair::driver_config(), nowhere, [&told](const topic::Bodies&) { ++told; },
                        [&told](const topic::Mru&) { ++told; }};
  auto bytes = kReplyBytes;
  const std::size_t before = test::allocations;
  LabTime now{};
  for (int i = 0; i < 1000; ++i, now += 5ms) {
    driver.step(now);
    const auto t_s = static_cast<float>(seconds(now.time_since_epoch()));
    store<std::endian::little>(MutableBytes{bytes}.subspan(4, 4), t_s);
    store<std::endian::little>(MutableBytes{bytes}.subspan(136, 4), 0.001F * static_cast<float>(i));
    driver.on_datagram(bytes, kPlc, now);
    driver.on_datagram(Bytes{bytes}.first(100), kPlc, now);
  }
  EXPECT_EQ(test::allocations - before, 0U);
  EXPECT_GT(told, 2900U);
}

}  // namespace
}  // namespace motionlab::plc_reply
