#include "drivers/mru/mru_driver.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "drivers/core/random.hpp"
#include "drivers/mru/mru_wire_bin23.hpp"
#include "tests/mru/mru_golden.hpp"

namespace motionlab::mru {
namespace {

constexpr Endpoint kUnit{0xC0A85A0D, 50013};
const LabTime kStart = from_ns(1'000'000'000);

class MruDriverTest : public ::testing::Test {
 protected:
  MruDriverTest() : MruDriverTest(config()) {}
  explicit MruDriverTest(const DriverConfig& c)
      : dut_(c, [this](const topic::Mru& sample) { samples_.push_back(sample); }) {}

  static DriverConfig config() {
    DriverConfig c;
    c.source_address = kUnit.address;
    return c;
  }

  static ByteBuffer bytes(std::uint32_t system_time_ms, ChecksumRule rule = ChecksumRule::ones_complement) {
    ByteBuffer b{kLaboratoryFrame.begin(), kLaboratoryFrame.end()};
    store<std::endian::big>(MutableBytes{b}.subspan(3, 4), system_time_ms);
    b.back() = checksum(rule, Bytes{b}.subspan(2, 97));
    return b;
  }

  void receive(const ByteBuffer& b, LabTime t, Endpoint from = kUnit) { dut_.on_datagram(b, from, t); }

  std::vector<topic::Mru> samples_;
  MruDriver dut_;
};

TEST_F(MruDriverTest, TellsEveryValueOfTheConstructedFrame) {
  receive(bytes(123456), kStart);
  ASSERT_EQ(samples_.size(), 1u);
  const topic::Mru& s = samples_[0];
  EXPECT_EQ(s.device.view(), "mru1");
  EXPECT_EQ(s.sequence_number, 1u);
  EXPECT_TRUE(s.stable);
  EXPECT_FALSE(s.checksum_suspect);
  EXPECT_EQ(s.t_received_ns, to_ns(kStart));
  EXPECT_EQ(s.t_measured_ns, to_ns(kStart) - 5'000'000);
  const auto near = [](const std::array<double, 3>& a, double x, double y, double z) {
    EXPECT_NEAR(a[0], x, 1e-7);
    EXPECT_NEAR(a[1], y, 1e-7);
    EXPECT_NEAR(a[2], z, 1e-7);
  };
  near(s.euler_heading_mru_rad, 0.02, -0.03, 0.5);
  near(s.omega_mru_radps, 0.01, -0.02, 0.003);
  near(s.v_mru_mps, 0.1, -0.05, 0.2);
  near(s.a_mru_mps2, 0.01, 0.02, -0.04);
  near(s.p_heading_origin_m, 0.25, -0.10, -0.35);
  near(s.v_heading_origin_mps, 0.11, -0.06, 0.21);
  near(s.a_heading_origin_mps2, 0.02, 0.01, -0.05);
  EXPECT_NEAR(s.omega_down_radps, 0.002, 1e-9);
  EXPECT_NEAR(s.sensor_temperature_degc, 31.5, 1e-6);
}

TEST_F(MruDriverTest, CountsEveryReasonForRefusal) {
  receive(bytes(1000), kStart);
  receive(bytes(1005), kStart + 5ms, Endpoint{0x7F000001, 50013});
  receive(bytes(1000), kStart + 5ms);
  receive(bytes(995), kStart + 5ms);
  ByteBuffer b = bytes(1005);
  b.pop_back();
  receive(b, kStart + 5ms);
  b = bytes(1005);
  b.push_back(0);
  receive(b, kStart + 5ms);
  b = bytes(1005);
  b[0] = 0;
  receive(b, kStart + 5ms);
  b = bytes(1005);
  b[15] = 0x7F;  // roll becomes about 4e38
  receive(b, kStart + 5ms);
  for (const Reason reason : {Reason::foreign, Reason::duplicate, Reason::out_of_order, Reason::too_short,
                              Reason::too_long, Reason::bad_header, Reason::bad_value}) {
    EXPECT_EQ(dut_.health().rejected(reason), 1u) << to_string(reason);
  }
  EXPECT_EQ(dut_.health().rejected_total(), 7u);
  EXPECT_EQ(samples_.size(), 1u);
  receive(bytes(1005), kStart + 6ms);
  EXPECT_EQ(samples_.size(), 2u);
  EXPECT_EQ(dut_.health().lost(), 0u);
}

TEST_F(MruDriverTest, TakesAnySourcePortOfTheUnitsAddress) {
  receive(bytes(1000), kStart, Endpoint{kUnit.address, 61234});
  EXPECT_EQ(samples_.size(), 1u);
}

TEST_F(MruDriverTest, CountsGapsAsLost) {
  receive(bytes(1000), kStart);
  receive(bytes(1020), kStart + 20ms);
  EXPECT_EQ(dut_.health().lost(), 3u);
}

TEST_F(MruDriverTest, RunsThroughTheSignChangeAndTheWrap) {
  for (const std::uint32_t edge : {0x80000000u, 0u}) {
    MruDriver driver{config(), [this](const topic::Mru& sample) { samples_.push_back(sample); }};
    samples_.clear();
    for (std::uint32_t i = 0; i < 20; ++i) {
      driver.on_datagram(bytes(edge - 50 + 5 * i), kUnit, kStart + i * 5ms);
    }
    ASSERT_EQ(samples_.size(), 20u);
    EXPECT_EQ(driver.health().lost(), 0u);
    EXPECT_EQ(driver.health().reconnects(), 0u);
    for (std::size_t i = 1; i < samples_.size(); ++i) {
      EXPECT_EQ(samples_[i].t_measured_ns - samples_[i - 1].t_measured_ns, 5'000'000);
    }
  }
}

TEST_F(MruDriverTest, StartsTheClockAfreshWhenTheUnitRestarts) {
  receive(bytes(3'000'000), kStart);
  receive(bytes(20), kStart + 10s);
  EXPECT_EQ(dut_.health().reconnects(), 1u);
  EXPECT_EQ(dut_.health().lost(), 0u);
  ASSERT_EQ(samples_.size(), 2u);
  EXPECT_EQ(samples_[1].t_measured_ns, to_ns(kStart + 10s) - 5'000'000);
}

TEST_F(MruDriverTest, SeesARestartThatLooksLikeALeapForward) {
  receive(bytes(0xF0000000u), kStart);
  receive(bytes(0), kStart + 10s);
  EXPECT_EQ(dut_.health().reconnects(), 1u);
  EXPECT_EQ(dut_.health().lost(), 0u);
  EXPECT_EQ(samples_.size(), 2u);
}

TEST_F(MruDriverTest, KeepsItsStampsWhenADatagramIsLate) {
  for (std::uint32_t i = 0; i < 10; ++i) receive(bytes(1000 + 5 * i), kStart + i * 5ms);
  receive(bytes(1050), kStart + 50ms + 30ms);
  EXPECT_NEAR(static_cast<double>(samples_.back().t_measured_ns), static_cast<double>(to_ns(kStart + 45ms)),
              1e5);
  EXPECT_EQ(samples_.back().t_received_ns, to_ns(kStart + 80ms));
}

TEST_F(MruDriverTest, SaysWhatIsWrongAndWhatToDo) {
  EXPECT_EQ(dut_.health().phase(), LinkPhase::connecting);
  dut_.step(kStart);
  EXPECT_TRUE(dut_.health().advice().empty());
  dut_.step(kStart + 101ms);
  EXPECT_EQ(dut_.health().phase(), LinkPhase::connecting);
  EXPECT_NE(dut_.health().advice().find("Nothing has come"), std::string_view::npos);
  receive(bytes(1000), kStart + 200ms);
  dut_.step(kStart + 201ms);
  EXPECT_EQ(dut_.health().phase(), LinkPhase::up);
  EXPECT_TRUE(dut_.health().advice().empty());
  dut_.step(kStart + 301ms);
  EXPECT_EQ(dut_.health().phase(), LinkPhase::down);
  EXPECT_NE(dut_.health().advice().find("fallen silent"), std::string_view::npos);
  receive(bytes(1000), kStart + 310ms);
  dut_.step(kStart + 311ms);
  EXPECT_NE(dut_.health().advice().find("No good datagram"), std::string_view::npos);
  ByteBuffer b = bytes(1320);
  b[0] = kUnstableHeader;
  receive(b, kStart + 320ms);
  dut_.step(kStart + 321ms);
  EXPECT_FALSE(samples_.back().stable);
  EXPECT_NE(dut_.health().advice().find("settling"), std::string_view::npos);
}

TEST_F(MruDriverTest, StampsByArrivalWhenTheLayoutHasNoSystemTime) {
  DriverConfig c;
  c.layout.variables =
      VariableList::of(std::array{Variable::roll, Variable::pitch, Variable::yaw, Variable::pos_cg_d})
          .value();
  c.layout.token = 0x2F;
  MruDriver driver{c, [this](const topic::Mru& sample) { samples_.push_back(sample); }};
  driver.on_datagram(kPublished, kUnit, kStart);
  driver.on_datagram(kPublished, kUnit, kStart + 5ms);
  ASSERT_EQ(samples_.size(), 2u);
  EXPECT_EQ(samples_[1].t_measured_ns, to_ns(kStart));
  EXPECT_NEAR(samples_[1].euler_heading_mru_rad[0], 0.051, 1e-8);
  EXPECT_TRUE(std::isnan(samples_[1].omega_mru_radps[0]));
}

TEST_F(MruDriverTest, SurvivesRandomBytes) {
  Random random{3};
  for (int i = 0; i < 50000; ++i) {
    ByteBuffer b = bytes(static_cast<std::uint32_t>(random.bits()));
    b[random.below(100)] = static_cast<std::uint8_t>(random.bits());
    if (random.chance(0.2)) b.resize(random.below(200));
    receive(b, kStart + i * 5ms);
  }
  EXPECT_EQ(dut_.health().received() + dut_.health().rejected_total(), 50000u);
  EXPECT_EQ(samples_.size(), dut_.health().received());
}

ChecksumMatch match(bool sum8, bool ones_complement) {
  return {sum8, ones_complement};
}

TEST(ChecksumJudge, LocksTheRuleThatMatchesAlmostAlways) {
  ChecksumJudge dut{{}};
  for (int i = 0; i < 1000; ++i) {
    EXPECT_EQ(dut.state(), ChecksumJudge::State::scoring);
    EXPECT_EQ(dut.judge(match(i % 200 == 0, i % 200 != 0)), ChecksumJudge::Verdict::good);
  }
  EXPECT_EQ(dut.state(), ChecksumJudge::State::locked);
  EXPECT_EQ(dut.rule(), ChecksumRule::ones_complement);
  EXPECT_EQ(dut.judge(match(false, true)), ChecksumJudge::Verdict::good);
  EXPECT_EQ(dut.judge(match(true, false)), ChecksumJudge::Verdict::suspect);
  EXPECT_EQ(dut.mismatches(), 1u);
}

TEST(ChecksumJudge, LocksSum8Too) {
  ChecksumJudge dut{{.frames_to_score = 10}};
  for (int i = 0; i < 10; ++i) dut.judge(match(true, false));
  EXPECT_EQ(dut.rule(), ChecksumRule::sum8);
}

TEST(ChecksumJudge, SaysUnknownWhenNoRuleOrBothRulesMatch) {
  for (const bool both : {false, true}) {
    ChecksumJudge dut{{.policy = ChecksumPolicy::enforce, .frames_to_score = 100}};
    for (int i = 0; i < 100; ++i) dut.judge(match(both, both || i == 7));
    EXPECT_EQ(dut.state(), ChecksumJudge::State::unknown);
    EXPECT_FALSE(dut.rule());
    EXPECT_EQ(dut.judge(match(false, false)), ChecksumJudge::Verdict::good);
  }
}

TEST(ChecksumJudge, NeedsMoreThanTheShare) {
  ChecksumJudge dut{{}};
  for (int i = 0; i < 1000; ++i) dut.judge(match(i >= 10, false));  // exactly 99 %
  EXPECT_EQ(dut.state(), ChecksumJudge::State::unknown);
}

TEST(ChecksumJudge, EnforcesAConfiguredRuleFromTheFirstFrame) {
  ChecksumJudge dut{{.policy = ChecksumPolicy::enforce, .rule = ChecksumRule::sum8}};
  EXPECT_EQ(dut.judge(match(false, true)), ChecksumJudge::Verdict::refuse);
  EXPECT_EQ(dut.judge(match(true, false)), ChecksumJudge::Verdict::good);
}

TEST(ChecksumJudge, LooksAtNothingWhenToldToIgnore) {
  ChecksumJudge dut{{.policy = ChecksumPolicy::ignore, .rule = ChecksumRule::sum8}};
  EXPECT_EQ(dut.judge(match(false, false)), ChecksumJudge::Verdict::good);
  EXPECT_EQ(dut.mismatches(), 0u);
}

TEST_F(MruDriverTest, RefusesABadChecksumOnlyWhenEnforced) {
  DriverConfig c = config();
  c.checksum = {.policy = ChecksumPolicy::enforce, .rule = ChecksumRule::ones_complement};
  MruDriver enforcing{c, nullptr};
  enforcing.on_datagram(bytes(1000, ChecksumRule::sum8), kUnit, kStart);
  EXPECT_EQ(enforcing.health().rejected(Reason::bad_checksum), 1u);
  EXPECT_EQ(enforcing.health().received(), 0u);

  c.checksum.policy = ChecksumPolicy::count;
  MruDriver counting{c, [this](const topic::Mru& sample) { samples_.push_back(sample); }};
  counting.on_datagram(bytes(1000, ChecksumRule::sum8), kUnit, kStart);
  ASSERT_EQ(samples_.size(), 1u);
  EXPECT_TRUE(samples_[0].checksum_suspect);
  EXPECT_EQ(counting.checksum().mismatches(), 1u);
}

TEST(ChecksumJudge, JudgesAFormatWithOneRuleFromTheFirstDatagram) {
  ChecksumJudge counting{{}};
  EXPECT_EQ(counting.judge(false), ChecksumJudge::Verdict::suspect);
  EXPECT_EQ(counting.judge(true), ChecksumJudge::Verdict::good);
  EXPECT_EQ(counting.mismatches(), 1u);
  ChecksumJudge enforcing{{.policy = ChecksumPolicy::enforce}};
  EXPECT_EQ(enforcing.judge(false), ChecksumJudge::Verdict::refuse);
  ChecksumJudge ignoring{{.policy = ChecksumPolicy::ignore}};
  EXPECT_EQ(ignoring.judge(false), ChecksumJudge::Verdict::good);
}

/// A driver for the formats with UTC, fed with constructed datagrams.
class UtcDriver : public ::testing::Test {
 protected:
  /// BIN23 says so many tenths of a millisecond after the golden datagram's time.
  void receive(std::int64_t tenths_of_ms, LabTime t) {
    bin23::Frame frame = bin23::decode(kBin23Frame).value();
    const std::int64_t total = frame.utc_tenths_of_ms + tenths_of_ms;
    frame.utc_s += static_cast<std::int32_t>(total / 10'000);
    frame.utc_tenths_of_ms = static_cast<std::uint16_t>(total % 10'000);
    std::array<std::uint8_t, bin23::kSize> room{};
    dut_.on_datagram(bin23::encode(frame, room).value(), kUnit, t);
  }
  static DriverConfig utc_config() {
    DriverConfig c;
    c.format = Format::bin23;
    return c;
  }

  std::vector<topic::Mru> samples_;
  MruDriver dut_{utc_config(), [this](const topic::Mru& sample) { samples_.push_back(sample); }};
};

TEST_F(UtcDriver, KeepsWhatIsFinerThanAMillisecond) {
  receive(0, kStart);
  receive(53, kStart + 5300us);
  ASSERT_EQ(samples_.size(), 2u);
  EXPECT_EQ(samples_[1].t_measured_ns - samples_[0].t_measured_ns, 5'300'000);
}

TEST_F(UtcDriver, RunsThroughTheWrapOfItsMilliseconds) {
  // 1700000000250 ms is 3487918330 beyond a multiple of 2^32; the next one is 807048966 ms away.
  constexpr std::int64_t kToWrap_tenths = 8'070'489'660;
  for (int i = -100; i < 100; ++i) receive(kToWrap_tenths + 50 * i, kStart + (i + 100) * 5ms);
  EXPECT_EQ(samples_.size(), 200u);
  EXPECT_EQ(dut_.health().rejected_total(), 0u);
  EXPECT_EQ(dut_.health().reconnects(), 0u);
  EXPECT_EQ(dut_.health().lost(), 0u);
}

TEST_F(UtcDriver, CountsRepetitionReorderingGapAndStep) {
  receive(0, kStart);
  receive(0, kStart + 1ms);
  EXPECT_EQ(dut_.health().rejected(Reason::duplicate), 1u);
  receive(200, kStart + 20ms);
  EXPECT_EQ(dut_.health().lost(), 3u);
  receive(150, kStart + 21ms);
  EXPECT_EQ(dut_.health().rejected(Reason::out_of_order), 1u);
  receive(36'000'000, kStart + 25ms);
  EXPECT_EQ(dut_.health().reconnects(), 1u) << "an hour ahead: the unit's clock was set";
  EXPECT_EQ(samples_.back().t_measured_ns, to_ns(kStart + 20ms));
}

TEST(Stillness, SaysStuckOnlyAfterItsLimitAndNoLongerThanItLasts) {
  Stillness dut{500ms};
  Motion motion;
  motion.euler_heading_mru_rad = {0.1, 0.2, 0.3};
  for (LabTime t = kStart; t <= kStart + 500ms; t += 5ms) EXPECT_FALSE(dut.stuck(motion, t));
  EXPECT_TRUE(dut.stuck(motion, kStart + 505ms));
  motion.sensor_temperature_degc = 40;
  EXPECT_TRUE(dut.stuck(motion, kStart + 510ms)) << "the temperature is no motion";
  motion.euler_heading_mru_rad[0] = std::nextafter(0.1, 1.0);
  EXPECT_FALSE(dut.stuck(motion, kStart + 515ms));
  Stillness never{0ms};
  for (LabTime t = kStart; t < kStart + 10s; t += 100ms) EXPECT_FALSE(never.stuck(motion, t));
}

}  // namespace
}  // namespace motionlab::mru
