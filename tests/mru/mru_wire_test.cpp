#include "drivers/mru/mru_wire.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <set>
#include <string>
#include <vector>

#include "drivers/core/random.hpp"
#include "tests/mru/mru_frames.hpp"

namespace motionlab::mru {
namespace {

Layout published_layout() {
  Layout layout;
  layout.variables =
      VariableList::of(std::array{Variable::roll, Variable::pitch, Variable::yaw, Variable::pos_cg_d})
          .value();
  layout.token = 0x2F;
  return layout;
}

ByteBuffer laboratory_bytes() {
  return {kLaboratoryFrame.begin(), kLaboratoryFrame.end()};
}

/// Writes a float over value number `index` of a datagram.
void overwrite(ByteBuffer& bytes, std::size_t index, float value) {
  store<std::endian::big>(MutableBytes{bytes}.subspan(3 + 4 * index, 4), value);
}

TEST(MruWire, DecodesThePublishedFrame) {
  const Layout layout = published_layout();
  const auto frame = decode(kPublished, layout);
  ASSERT_TRUE(frame.ok());
  EXPECT_TRUE(frame->stable);
  EXPECT_EQ(frame->token, 0x2F);
  EXPECT_EQ(frame->checksum, 0xCB);
  EXPECT_FALSE(frame->checksum_match.sum8);
  EXPECT_TRUE(frame->checksum_match.ones_complement);
  EXPECT_NEAR(*frame->value(Variable::roll, layout), 0.051, 1e-8);
  EXPECT_NEAR(*frame->value(Variable::pitch, layout), -0.051, 1e-8);
  EXPECT_NEAR(*frame->value(Variable::yaw, layout), -0.204, 1e-7);
  EXPECT_NEAR(*frame->value(Variable::pos_cg_d, layout), 1.234, 1e-6);
  EXPECT_FALSE(frame->value(Variable::ang_rate_r, layout));
  EXPECT_FALSE(frame->system_time_ms(layout));
}

TEST(MruWire, DecodesTheConstructedLaboratoryFrame) {
  const Layout layout;
  ASSERT_EQ(layout.datagram_size(), 100u);
  const auto frame = decode(kLaboratoryFrame, layout);
  ASSERT_TRUE(frame.ok());
  EXPECT_EQ(*frame->system_time_ms(layout), 123456u);
  const std::vector<std::pair<Variable, double>> expected{{Variable::sensor_temperature, 31.5},
                                                          {Variable::ang_rate_d, 0.002},
                                                          {Variable::roll, 0.02},
                                                          {Variable::pitch, -0.03},
                                                          {Variable::yaw, 0.5},
                                                          {Variable::ang_rate_r, 0.01},
                                                          {Variable::ang_rate_p, -0.02},
                                                          {Variable::ang_rate_y, 0.003},
                                                          {Variable::vel_mru_r, 0.1},
                                                          {Variable::vel_mru_p, -0.05},
                                                          {Variable::vel_mru_y, 0.2},
                                                          {Variable::acc_mru_r, 0.01},
                                                          {Variable::acc_mru_p, 0.02},
                                                          {Variable::acc_mru_y, -0.04},
                                                          {Variable::pos_cg_f, 0.25},
                                                          {Variable::pos_cg_s, -0.10},
                                                          {Variable::pos_cg_d, -0.35},
                                                          {Variable::vel_cg_f, 0.11},
                                                          {Variable::vel_cg_s, -0.06},
                                                          {Variable::vel_cg_d, 0.21},
                                                          {Variable::acc_cg_f, 0.02},
                                                          {Variable::acc_cg_s, 0.01},
                                                          {Variable::acc_cg_d, -0.05}};
  for (const auto& [variable, value] : expected) {
    EXPECT_NEAR(*frame->value(variable, layout), value, 1e-7) << facts_of(variable)->name;
  }
}

TEST(MruWire, SaysWhichChecksumRuleMatches) {
  ByteBuffer bytes = laboratory_bytes();
  auto match = decode(bytes, {})->checksum_match;
  EXPECT_FALSE(match.sum8);
  EXPECT_TRUE(match.ones_complement);
  bytes.back() = 0x5E;
  match = decode(bytes, {})->checksum_match;
  EXPECT_TRUE(match.sum8);
  EXPECT_FALSE(match.ones_complement);
  bytes.back() = 0x00;
  match = decode(bytes, {})->checksum_match;
  EXPECT_FALSE(match.sum8);
  EXPECT_FALSE(match.ones_complement);
}

TEST(MruWire, TreatsTheTwoZerosOfOnesComplementAsEqual) {
  // 0x2F + 0xD0 = 0xFF: the sum is a multiple of 255, the inverted sum 0x00 or 0xFF.
  const Layout layout = published_layout();
  ByteBuffer bytes(20, 0);
  bytes[0] = 0x71;
  bytes[1] = 0x11;
  bytes[2] = 0x2F;
  bytes[6] = 0xD0;
  for (const std::uint8_t zero : {std::uint8_t{0x00}, std::uint8_t{0xFF}}) {
    bytes[19] = zero;
    const auto frame = decode(bytes, layout);
    ASSERT_TRUE(frame.ok());
    EXPECT_TRUE(frame->checksum_match.ones_complement);
  }
}

TEST(MruWire, KnowsThatCapitalQMeansUnstable) {
  ByteBuffer bytes = laboratory_bytes();
  bytes[0] = 0x51;
  ASSERT_TRUE(decode(bytes, {}).ok());
  EXPECT_FALSE(decode(bytes, {})->stable);
}

TEST(MruWire, RefusesADatagramOneByteShort) {
  ByteBuffer bytes = laboratory_bytes();
  bytes.pop_back();
  EXPECT_EQ(decode(bytes, {}).fault().reason, Reason::too_short);
}

TEST(MruWire, RefusesADatagramOneByteLong) {
  ByteBuffer bytes = laboratory_bytes();
  bytes.push_back(0);
  EXPECT_EQ(decode(bytes, {}).fault().reason, Reason::too_long);
}

TEST(MruWire, RefusesEveryTruncation) {
  for (std::size_t n = 0; n < kLaboratoryFrame.size(); ++n) {
    EXPECT_EQ(decode(Bytes{kLaboratoryFrame}.first(n), {}).fault().reason, Reason::too_short) << n;
  }
}

TEST(MruWire, GivesEveryCauseATextOfItsOwn) {
  std::set<std::string_view> texts;
  const auto refuse = [&](const ByteBuffer& bytes, Reason reason) {
    const auto frame = decode(bytes, {});
    ASSERT_FALSE(frame.ok());
    EXPECT_EQ(frame.fault().reason, reason) << frame.fault().text;
    EXPECT_TRUE(texts.insert(frame.fault().text).second) << frame.fault().text;
  };
  ByteBuffer bytes = laboratory_bytes();
  refuse({0x71, 0x61}, Reason::too_short);
  bytes[0] = 0x72;
  refuse(bytes, Reason::bad_header);
  bytes = laboratory_bytes();
  bytes[1] = 0x60;
  refuse(bytes, Reason::bad_header);
  bytes = laboratory_bytes();
  bytes[1] = 0x65;
  refuse(bytes, Reason::too_short);
  bytes[1] = 0x5D;
  refuse(bytes, Reason::too_long);
  bytes = laboratory_bytes();
  bytes[2] = 12;
  refuse(bytes, Reason::bad_header);
  bytes = laboratory_bytes();
  bytes.resize(96);
  bytes[1] = 0x5D;
  refuse(bytes, Reason::bad_header);
  bytes = laboratory_bytes();
  overwrite(bytes, 9, std::numeric_limits<float>::quiet_NaN());
  refuse(bytes, Reason::bad_value);
  bytes = laboratory_bytes();
  overwrite(bytes, 3, 1.6F);
  refuse(bytes, Reason::bad_value);
  bytes = laboratory_bytes();
  overwrite(bytes, 17, -10.5F);
  refuse(bytes, Reason::bad_value);
  bytes = laboratory_bytes();
  overwrite(bytes, 6, 10.5F);
  refuse(bytes, Reason::bad_value);
}

TEST(MruWire, RefusesInfinityInEveryFloat) {
  for (std::size_t i = 1; i < 24; ++i) {
    ByteBuffer bytes = laboratory_bytes();
    overwrite(bytes, i, -std::numeric_limits<float>::infinity());
    EXPECT_EQ(decode(bytes, {}).fault().reason, Reason::bad_value) << i;
  }
}

TEST(MruWire, AcceptsValuesAtTheirLimitAndObeysOtherLimits) {
  ByteBuffer bytes = laboratory_bytes();
  overwrite(bytes, 4, std::numbers::pi_v<float> / 2);
  overwrite(bytes, 17, 10.0F);
  overwrite(bytes, 2, -10.0F);
  EXPECT_TRUE(decode(bytes, {}).ok());
  Layout strict;
  strict.limits.heave_m = 1.0;
  EXPECT_FALSE(decode(bytes, strict).ok());
}

TEST(MruWire, ReadsSystemTimeBeyond31BitsAsUnsigned) {
  ByteBuffer bytes = laboratory_bytes();
  store<std::endian::big>(MutableBytes{bytes}.subspan(3, 4), std::uint32_t{0xFFFFFFFE});
  const Layout layout;
  EXPECT_EQ(*decode(bytes, layout)->system_time_ms(layout), 0xFFFFFFFEu);
}

TEST(MruWire, EncodesTheGoldenFramesByteForByte) {
  std::array<std::uint8_t, kMaxDatagram> room{};
  const Layout published = published_layout();
  const auto short_bytes =
      encode(decode(kPublished, published).value(), published, ChecksumRule::ones_complement, room);
  ASSERT_TRUE(short_bytes.ok());
  EXPECT_TRUE(std::ranges::equal(*short_bytes, kPublished));

  const auto bytes = encode(decode(kLaboratoryFrame, {}).value(), {}, ChecksumRule::ones_complement, room);
  ASSERT_TRUE(bytes.ok());
  EXPECT_TRUE(std::ranges::equal(*bytes, kLaboratoryFrame));

  const auto summed = encode(decode(kLaboratoryFrame, {}).value(), {}, ChecksumRule::sum8, room);
  EXPECT_EQ(summed->back(), 0x5E);
}

TEST(MruWire, RefusesToEncodeIntoTooLittleRoomOrAnIntegerThatIsNotFinite) {
  std::array<std::uint8_t, 100> room{};
  Frame frame = decode(kLaboratoryFrame, {}).value();
  EXPECT_EQ(encode(frame, {}, ChecksumRule::sum8, MutableBytes{room}.first(99)).fault().reason,
            Reason::too_short);
  frame.values[0] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(encode(frame, {}, ChecksumRule::sum8, room).fault().reason, Reason::bad_value);
}

TEST(MruWire, RefusesVariableListsThatMakeNoLayout) {
  EXPECT_FALSE(VariableList::of({}).ok());
  EXPECT_FALSE(VariableList::of(std::array{Variable::roll, Variable::roll}).ok());
  EXPECT_FALSE(VariableList::of(std::array{static_cast<Variable>(999)}).ok());
  EXPECT_FALSE(VariableList::of(std::vector<Variable>(64, Variable::roll)).ok());
}

TEST(MruWire, SurvivesRandomBytesAndAcceptsOnlyWhatItCanRepeat) {
  Random random{7};
  std::array<std::uint8_t, kMaxDatagram> room{};
  std::size_t accepted = 0;
  for (int i = 0; i < 200000; ++i) {
    ByteBuffer bytes = laboratory_bytes();
    const auto changes = random.below(4);
    for (std::uint32_t k = 0; k < changes; ++k) {
      bytes[random.below(100)] = static_cast<std::uint8_t>(random.bits());
    }
    if (random.chance(0.1)) bytes.resize(random.below(300));
    const auto frame = decode(bytes, {});
    if (!frame) continue;
    ++accepted;
    const auto again = encode(*frame, {}, ChecksumRule::sum8, room);
    ASSERT_TRUE(again.ok());
    ASSERT_TRUE(std::equal(bytes.begin(), bytes.end() - 1, again->begin(), again->end() - 1));
  }
  EXPECT_GT(accepted, 10000u);
}

}  // namespace
}  // namespace motionlab::mru
