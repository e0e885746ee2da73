/// The formats besides MRUBIN, against published and constructed datagrams.
#include "drivers/mru/mru_wire_formats.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>

#include "drivers/core/random.hpp"
#include "drivers/mru/mru_wire_bin23.hpp"
#include "drivers/mru/mru_wire_em3000.hpp"
#include "drivers/mru/mru_wire_km.hpp"
#include "drivers/mru/mru_wire_nmeap.hpp"
#include "drivers/mru/mru_wire_tss1.hpp"
#include "tests/mru/mru_golden.hpp"

namespace motionlab::mru {
namespace {

constexpr double kTolerance = 1e-6;

void expect_degrees(const Motion::Triple& radians, double a, double b, double c,
                    double tolerance = kTolerance) {
  EXPECT_NEAR(radians[0] / kDegree, a, tolerance);
  EXPECT_NEAR(radians[1] / kDegree, b, tolerance);
  EXPECT_NEAR(radians[2] / kDegree, c, tolerance);
}

void expect_triple(const Motion::Triple& values, double a, double b, double c) {
  EXPECT_NEAR(values[0], a, kTolerance);
  EXPECT_NEAR(values[1], b, kTolerance);
  EXPECT_NEAR(values[2], c, kTolerance);
}

Motion motion_in(Format format, Bytes bytes) {
  Decoder decoder{format, {}};
  const auto heard = decoder.decode(bytes);
  EXPECT_TRUE(heard.ok()) << (heard.ok() ? "" : heard.fault().text);
  if (!heard || !*heard) {
    ADD_FAILURE() << "no motion";
    return {};
  }
  return (*heard)->motion;
}

TEST(MruFormats, HippyRollFollowsThePublishedRelation) {
  EXPECT_NEAR(hippy_roll(5 * kDegree, 5 * kDegree) / kDegree, 4.980925, 1e-6);
  EXPECT_NEAR(euler_roll(4.980925 * kDegree, 5 * kDegree) / kDegree, 5.0, 1e-6);
  for (double roll = -1.2; roll < 1.25; roll += 0.1) {
    for (double pitch = -1.2; pitch < 1.25; pitch += 0.1) {
      EXPECT_NEAR(euler_roll(hippy_roll(roll, pitch), pitch), roll, 1e-12);
    }
  }
}

TEST(MruFormats, NoEulerRollBelongsToAHippyRollThatThePitchForbids) {
  EXPECT_TRUE(std::isnan(euler_roll(60 * kDegree, 50 * kDegree)));
  EXPECT_TRUE(std::isnan(euler_roll(100 * kDegree, 0.0)));
}

TEST(MruFormats, HeadingAndYawAreInverse) {
  EXPECT_NEAR(yaw_of_heading(270.0), -std::numbers::pi / 2, 1e-12);
  EXPECT_NEAR(yaw_of_heading(180.0), std::numbers::pi, 1e-12);
  EXPECT_EQ(heading_of_yaw(-1e-18), 0.0);
  for (double heading = 0.0; heading < 360.0; heading += 7.5) {
    EXPECT_NEAR(heading_of_yaw(yaw_of_heading(heading)), heading, 1e-9);
  }
}

TEST(MruFormats, WhatMovesEastWhileLookingWestMovesAstern) {
  expect_triple(heading_from_ned({0, 1, 2}, yaw_of_heading(270)), -1, 0, 2);
  expect_triple(ned_from_heading({-1, 0, 2}, yaw_of_heading(270)), 0, 1, 2);
}

TEST(MruFormats, KmBinaryMeansWhatItSays) {
  const auto frame = km::decode(kKmFrame);
  ASSERT_TRUE(frame.ok());
  EXPECT_EQ(frame->utc_s, 1700000000u);
  EXPECT_EQ(frame->utc_ns, 250000000u);
  EXPECT_EQ(frame->status, 0u);
  EXPECT_NEAR(frame->latitude_deg, 58.3343, 1e-9);
  EXPECT_NEAR(frame->longitude_deg, 8.5770, 1e-9);
  EXPECT_EQ(frame->height_up_m, 40.5F);
  EXPECT_EQ(frame->position_error_m, (std::array{0.5F, 0.5F, 1.0F}));
  EXPECT_EQ(frame->roll_pitch_heading_error_deg, (std::array{0.02F, 0.02F, 0.05F}));
  EXPECT_EQ(frame->heave_error_m, 0.05F);
  EXPECT_EQ(frame->delayed_utc_s, 1699999990u);
  EXPECT_EQ(frame->delayed_utc_ns, 500000000u);
  EXPECT_EQ(frame->delayed_heave_down_m, -0.125F);

  const Motion motion = motion_in(Format::km_binary, kKmFrame);
  EXPECT_TRUE(motion.stable);
  EXPECT_FALSE(motion.reduced);
  expect_degrees(motion.euler_heading_mru_rad, 1.5, -0.75, -90);
  EXPECT_NEAR(motion.p_heading_origin_m[2], 0.25, kTolerance);
  expect_degrees(motion.omega_mru_radps, 0.5, -0.25, 0.125);
  // Heading 270: north is to starboard, west is ahead.
  expect_triple(motion.v_heading_origin_mps, 2, 1, 0.0625);
  expect_triple(motion.a_heading_origin_mps2, 0.25, 0.125, 0.5);
  ASSERT_TRUE(motion.t_unit);
  EXPECT_EQ(motion.t_unit->ms, static_cast<std::uint32_t>(1700000000250));
}

TEST(MruFormats, KmBinaryStatusBecomesQuality) {
  const auto with = [](std::uint32_t status) {
    km::Frame frame = km::decode(kKmFrame).value();
    frame.status = status;
    return km::motion_of(frame);
  };
  EXPECT_FALSE(with(km::kRollPitch).stable);
  EXPECT_FALSE(with(km::kHeave).stable);
  EXPECT_TRUE(std::isnan(with(km::kHeave).p_heading_origin_m[2]));
  EXPECT_TRUE(std::isnan(with(km::kHeading).euler_heading_mru_rad[2]));
  EXPECT_TRUE(std::isnan(with(km::kHeading).v_heading_origin_mps[0]));
  EXPECT_NEAR(with(km::kHeading).v_heading_origin_mps[2], 0.0625, kTolerance);
  EXPECT_TRUE(std::isnan(with(km::kPosition).v_heading_origin_mps[1]));
  EXPECT_TRUE(std::isnan(with(km::kAcceleration).a_heading_origin_mps2[0]));
  EXPECT_TRUE(with(km::kDelayedHeave | km::kPosition).stable);
  EXPECT_TRUE(with(km::kRollPitch << km::kReduced).reduced);
  EXPECT_TRUE(with(km::kRollPitch << km::kReduced).stable);
}

TEST(MruFormats, Em3000IsTurnedToHeaveDown) {
  const Motion motion = motion_in(Format::em3000, kEm3000Frame);
  EXPECT_TRUE(motion.stable);
  expect_degrees(motion.euler_heading_mru_rad, 1.23, -0.45, -90);
  EXPECT_NEAR(motion.p_heading_origin_m[2], -0.67, kTolerance);
  EXPECT_FALSE(motion.t_unit);
  EXPECT_TRUE(std::isnan(motion.omega_mru_radps[0]));
}

TEST(MruFormats, Em1000HasHippyRoll) {
  const Motion motion = motion_in(Format::em1000, kEm1000Frame);
  EXPECT_NEAR(motion.euler_heading_mru_rad[0] / kDegree, 1.230038, 1e-6);
  EXPECT_NEAR(motion.euler_heading_mru_rad[1] / kDegree, -0.45, kTolerance);
}

TEST(MruFormats, Em3000AndEm1000AreNotTakenForEachOther) {
  Decoder em3000{Format::em3000, {}}, em1000{Format::em1000, {}};
  EXPECT_EQ(em3000.decode(kEm1000Frame).fault().reason, Reason::bad_header);
  EXPECT_EQ(em1000.decode(kEm3000Frame).fault().reason, Reason::bad_header);
}

TEST(MruFormats, Em3000StatusBecomesQuality) {
  for (int status = 0; status < 256; ++status) {
    auto bytes = kEm3000Frame;
    bytes[0] = static_cast<std::uint8_t>(status);
    const auto frame = em3000::decode(bytes);
    const bool exists = status == 0 || (status >= 0x90 && status <= 0xAF);
    ASSERT_EQ(frame.ok(), exists) << status;
    if (!exists) continue;
    const Motion motion = em3000::motion_of(*frame).value();
    EXPECT_EQ(motion.stable, status <= 0x99) << status;
    EXPECT_EQ(motion.reduced, status >= 0x91 && status <= 0x99) << status;
  }
}

TEST(MruFormats, Em3000OutOfRangeIsInvalid) {
  em3000::Frame frame = em3000::decode(kEm3000Frame).value();
  frame.heave_up_cm = 1000;
  frame.heading_cdeg = 36000;
  const Motion motion = em3000::motion_of(frame).value();
  EXPECT_TRUE(std::isnan(motion.p_heading_origin_m[2]));
  EXPECT_TRUE(std::isnan(motion.euler_heading_mru_rad[2]));
  frame.roll_cdeg = 18000;
  EXPECT_EQ(em3000::motion_of(frame).fault().reason, Reason::bad_value);
  frame.roll_cdeg = std::numeric_limits<std::int16_t>::min();
  EXPECT_EQ(em3000::motion_of(frame).fault().reason, Reason::bad_value);
}

TEST(MruFormats, Tss1OfTheHealyMeansWhatTheNoteSays) {
  const auto frame = tss1::decode(as_bytes(kTss1Healy));
  ASSERT_TRUE(frame.ok());
  EXPECT_EQ(frame->aiding, tss1::Aiding::none);
  const Motion motion = motion_in(Format::tss1, as_bytes(kTss1Healy));
  EXPECT_TRUE(motion.stable);
  EXPECT_NEAR(motion.p_heading_origin_m[2], 0.03, kTolerance);
  EXPECT_NEAR(motion.a_heading_origin_mps2[2], -0.0625, kTolerance);
  EXPECT_NEAR(motion.euler_heading_mru_rad[0], euler_roll(0.07 * kDegree, -0.56 * kDegree), 1e-9);
  EXPECT_NEAR(motion.euler_heading_mru_rad[1] / kDegree, -0.56, kTolerance);
  EXPECT_TRUE(std::isnan(motion.euler_heading_mru_rad[2]));
}

TEST(MruFormats, Tss1OfNovatelMeansWhatItsPageSays) {
  const auto frame = tss1::decode(as_bytes(kTss1Novatel));
  ASSERT_TRUE(frame.ok());
  EXPECT_EQ(frame->aiding, tss1::Aiding::full);
  EXPECT_TRUE(frame->settled);
  EXPECT_EQ(frame->a_up_counts, -54);
  EXPECT_EQ(frame->heave_up_cm, -3);
  EXPECT_EQ(frame->roll_cdeg, -325);
  EXPECT_EQ(frame->pitch_cdeg, 319);
  EXPECT_NEAR(motion_in(Format::tss1, as_bytes(kTss1Novatel)).a_heading_origin_mps2[2], 0.03375, kTolerance);
}

TEST(MruFormats, Tss1SmallLetterMeansUnsettled) {
  for (const char letter : std::string{"uUgGhHfF"}) {
    std::string line{kTss1Healy};
    line[13] = letter;
    const auto frame = tss1::decode(as_bytes(line));
    ASSERT_TRUE(frame.ok()) << letter;
    EXPECT_EQ(tss1::motion_of(*frame).stable, letter < 'a') << letter;
  }
}

TEST(MruFormats, Tss1RefusesAWrongCharacterInEveryPlace) {
  for (std::size_t i = 0; i < tss1::kSize; ++i) {
    std::string line{kTss1Healy};
    line[i] = '?';
    const auto frame = tss1::decode(as_bytes(line));
    ASSERT_FALSE(frame.ok()) << i;
    EXPECT_EQ(frame.fault().reason, Reason::bad_header) << i;
  }
}

TEST(MruFormats, Psxn23OfThePublishedExamples) {
  const Motion motion = motion_in(Format::psxn, as_bytes(kPsxn23));
  expect_degrees(motion.euler_heading_mru_rad, 1.28, 1.93, 104.68);
  EXPECT_NEAR(motion.p_heading_origin_m[2], -0.24, kTolerance);
  expect_degrees(motion_in(Format::psxn, as_bytes(kPsxn23Level)).euler_heading_mru_rad, 0.05, 0.05, 89.4);
  expect_degrees(motion_in(Format::psxn, as_bytes(kPsxn23Port)).euler_heading_mru_rad, -2.82, 1.0, -124.82);
  for (const auto text : {kPsxn20, kPsxn23, kPsxn23Level, kPsxn23Port, kPsxn24, kPrdid}) {
    EXPECT_EQ(nmea::decode(text)->checksum, nmea::Checksum::good) << text;
  }
}

TEST(MruFormats, PsxnRatesBelongToTheNextTwoAttitudes) {
  nmea::Listener dut{nmea::Kind::attitude};
  ASSERT_TRUE(dut.take(as_bytes(kPsxn24)).ok());
  for (const bool has_rates : {true, true, false}) {
    const auto told = dut.take(as_bytes(kPsxn23));
    ASSERT_TRUE(told.ok() && *told);
    const Motion& motion = (*told)->motion;
    if (has_rates) {
      expect_degrees(motion.omega_mru_radps, 0.50, -0.25, 0.13);
      EXPECT_NEAR(motion.v_heading_origin_mps[2], 0.06, kTolerance);
    } else {
      EXPECT_TRUE(std::isnan(motion.omega_mru_radps[0]));
      EXPECT_TRUE(std::isnan(motion.v_heading_origin_mps[2]));
    }
  }
}

std::string sentence(nmea::Kind kind, std::array<double, 4> values) {
  std::array<std::uint8_t, nmea::kMaxSentence> room{};
  return std::string{as_text(nmea::encode({kind, {}, values}, room).value())};
}

TEST(MruFormats, PsxnQualityHoldsUntilTheNextWord) {
  nmea::Listener dut{nmea::Kind::attitude};
  const auto motion = [&](const std::string& before) {
    return (*dut.take(as_bytes(before + std::string{kPsxn23})))->motion;
  };
  EXPECT_TRUE(motion("").stable);
  EXPECT_FALSE(motion(sentence(nmea::Kind::quality, {0, 0, 0, 2})).stable);
  EXPECT_FALSE(motion("").stable);
  const Motion reduced = motion(sentence(nmea::Kind::quality, {0, 0, 2, 1}));
  EXPECT_TRUE(reduced.stable);
  EXPECT_TRUE(reduced.reduced);
  EXPECT_TRUE(std::isnan(reduced.euler_heading_mru_rad[2]));
  EXPECT_FALSE(motion(std::string{kPsxn20}).reduced);
  EXPECT_FALSE(motion(sentence(nmea::Kind::restart, {1})).stable);
  EXPECT_TRUE(motion(std::string{kPsxn20}).stable);
}

TEST(MruFormats, PsxnWithABadChecksumIsNotRemembered) {
  nmea::Listener dut{nmea::Kind::attitude};
  std::string invalid = sentence(nmea::Kind::quality, {0, 0, 0, 2});
  invalid[9] = '1';
  EXPECT_EQ(dut.take(as_bytes(invalid)).fault().reason, Reason::bad_checksum);
  const auto told = dut.take(as_bytes(kPsxn23));
  EXPECT_TRUE((*told)->motion.stable);
  EXPECT_TRUE((*told)->check.good);
  std::string wrong{kPsxn23};
  wrong[10] = '2';
  EXPECT_FALSE((*dut.take(as_bytes(wrong)))->check.good);
}

TEST(MruFormats, AChecksumMayLackItsLeadingZero) {
  EXPECT_EQ(nmea::decode("$PSXN,23,0.05,0.05,89.40,0.00*D\r\n")->checksum, nmea::Checksum::good);
}

TEST(MruFormats, PrdidHasPitchFirstAndNeedsNoChecksum) {
  expect_degrees(motion_in(Format::prdid, as_bytes(kPrdid)).euler_heading_mru_rad, 1.5, -0.75, -90);
  Decoder decoder{Format::prdid, {}};
  const auto bare = decoder.decode(as_bytes("$PRDID,-0.75,1.50,270.00\r\n"));
  ASSERT_TRUE(bare.ok() && *bare);
  EXPECT_EQ((*bare)->check.rule, Check::Rule::none);
  std::string wrong{kPrdid};
  wrong[25] = '8';
  EXPECT_FALSE((*decoder.decode(as_bytes(wrong)))->check.good);
}

TEST(MruFormats, SentencesOfOthersArePassedOver) {
  Decoder decoder{Format::psxn, {}};
  const auto alone = decoder.decode(as_bytes("$HEHDT,104.68,T*1B\r\n"));
  EXPECT_EQ(alone.fault().reason, Reason::bad_header);
  const auto among = decoder.decode(as_bytes("$HEHDT,104.68,T*1B\r\n" + std::string{kPsxn23}));
  ASSERT_TRUE(among.ok());
  EXPECT_TRUE(among->has_value());
}

TEST(MruFormats, SentencesThatAreNoneAreRefusedForTheirReason) {
  const auto reason = [](std::string_view text) { return nmea::decode(text).fault().reason; };
  EXPECT_EQ(reason(""), Reason::too_short);
  EXPECT_EQ(reason("$PSXN,23,1,2,3,4*00"), Reason::too_short);
  EXPECT_EQ(reason(std::string(200, '$')), Reason::too_long);
  EXPECT_EQ(reason("PSXN,23,1,2,3,4*00\r\n"), Reason::bad_header);
  EXPECT_EQ(reason("$PSXN,23,1,2,3*00\r\n"), Reason::bad_header);
  EXPECT_EQ(reason("$PSXN,23,1,2,3,4,5*00\r\n"), Reason::bad_header);
  for (const char* const field : {"nan", "inf", "1e3", "1.2.3", "--1", "0x1", "+1", "-", " 1"}) {
    EXPECT_EQ(reason("$PSXN,23," + std::string{field} + ",2,3,4*00\r\n"), Reason::bad_value) << field;
  }
  Decoder decoder{Format::psxn, {}};
  EXPECT_EQ(decoder.decode(as_bytes("$PSXN,23,,1.93,104.68,-0.24*25\r\n")).fault().reason, Reason::bad_value)
      << "an empty roll";
}

TEST(MruFormats, Bin23MeansWhatItSays) {
  EXPECT_EQ(bin23::crc(as_bytes("123456789")), 0x906E);
  const auto frame = bin23::decode(kBin23Frame);
  ASSERT_TRUE(frame.ok());
  EXPECT_TRUE(frame->crc_good);
  EXPECT_EQ(frame->utc_s, 1700000000);
  EXPECT_EQ(frame->utc_tenths_of_ms, 2500);
  EXPECT_NEAR(frame->latitude_counts * 90.0 / (1 << 30), 58.3343, 1e-6);
  EXPECT_NEAR(frame->longitude_counts * 90.0 / (1 << 30), 8.5770, 1e-6);
  EXPECT_EQ(frame->height_up_cm, 4050);
  const Motion motion = motion_in(Format::bin23, kBin23Frame);
  EXPECT_TRUE(motion.stable);
  expect_degrees(motion.euler_heading_mru_rad, 1.49963, -0.75256, -90, 1e-5);
  expect_degrees(motion.omega_mru_radps, 0.49988, -0.25269, 0.12634, 1e-5);
  EXPECT_NEAR(motion.p_heading_origin_m[2], 0.25, kTolerance);
  expect_triple(motion.v_heading_origin_mps, 2, 1, 0.06);
  ASSERT_TRUE(motion.t_unit);
  EXPECT_EQ(motion.t_unit->ms, static_cast<std::uint32_t>(1700000000250));
}

TEST(MruFormats, Bin23StatusBecomesQuality) {
  const auto with = [](std::uint16_t status) {
    bin23::Frame frame = bin23::decode(kBin23Frame).value();
    frame.status = status;
    return bin23::motion_of(frame);
  };
  EXPECT_FALSE(with(bin23::kRollPitchInvalid).stable);
  EXPECT_FALSE(with(bin23::kHeaveInvalid).stable);
  EXPECT_TRUE(std::isnan(with(bin23::kHeaveInvalid).p_heading_origin_m[2]));
  EXPECT_TRUE(std::isnan(with(bin23::kHeadingInvalid).euler_heading_mru_rad[2]));
  EXPECT_TRUE(std::isnan(with(bin23::kPositionInvalid).v_heading_origin_mps[0]));
  EXPECT_TRUE(with(bin23::kPositionReduced | bin23::kPositionInvalid).stable);
  for (const auto status : {bin23::kHeaveReduced, bin23::kRollPitchReduced, bin23::kHeadingReduced}) {
    EXPECT_TRUE(with(status).reduced);
    EXPECT_TRUE(with(status).stable);
  }
}

TEST(MruFormats, Bin23NoticesEveryFlippedBitThatItsCrcCovers) {
  for (std::size_t bit = 16; bit < 8 * kBin23Frame.size(); ++bit) {
    auto bytes = kBin23Frame;
    bytes[bit / 8] ^= static_cast<std::uint8_t>(1u << (bit % 8));
    const auto frame = bin23::decode(bytes);
    EXPECT_TRUE(!frame.ok() || !frame->crc_good) << bit;
  }
}

TEST(MruFormats, NmeapIsTheUsersListAsText) {
  Decoder decoder{Format::nmeap, nmeap_layout()};
  const auto heard = decoder.decode(as_bytes(kNmeap));
  ASSERT_TRUE(heard.ok() && *heard);
  const auto& [motion, check] = **heard;
  EXPECT_TRUE(motion.stable);
  EXPECT_EQ(check.rule, Check::Rule::known);
  EXPECT_TRUE(check.good);
  EXPECT_NEAR(motion.euler_heading_mru_rad[0] / kDegree, 1.5, kTolerance);
  EXPECT_NEAR(motion.euler_heading_mru_rad[1] / kDegree, -0.75, kTolerance);
  EXPECT_TRUE(std::isnan(motion.euler_heading_mru_rad[2]));
  EXPECT_NEAR(motion.p_heading_origin_m[2], 0.25, kTolerance);
  EXPECT_FALSE(motion.t_unit);

  const auto unsettled = decoder.decode(as_bytes("$PSXN,11,11,1.5,-0.75,0.25*3B\r\n"));
  ASSERT_TRUE(unsettled.ok() && *unsettled);
  EXPECT_FALSE((*unsettled)->motion.stable);
}

TEST(MruFormats, NmeapInRadiansIsTakenAsItStands) {
  Layout layout = nmeap_layout();
  layout.text_in_degrees = false;
  const auto read = nmeap::decode("$PSXN,10,011,0.026180,-0.013090,0.25*3A\r\n", layout);
  ASSERT_TRUE(read.ok());
  EXPECT_EQ(read->frame.values[0], 0.02618);
  EXPECT_EQ(read->frame.values[2], 0.25);
}

TEST(MruFormats, NmeapRefusesEachWithItsReason) {
  const auto reason = [](std::string_view text, const Layout& layout = nmeap_layout()) {
    const auto read = nmeap::decode(text, layout);
    return read.ok() ? std::optional<Reason>{} : read.fault().reason;
  };
  EXPECT_EQ(reason("$PSXN,10,012,1.50,-0.75,0.25*39\r\n"), Reason::bad_header) << "token";
  EXPECT_EQ(reason("$PSXN,10,1 1,1.50,-0.75,0.25*39\r\n"), Reason::bad_header) << "token";
  EXPECT_EQ(reason("$PSXN,10,011,1.50,-0.75*00\r\n"), Reason::bad_header) << "one variable too few";
  EXPECT_EQ(reason("$PSXN,10,011,1.50,-0.75,0.25,1*00\r\n"), Reason::bad_header) << "one too many";
  EXPECT_EQ(reason("$PSXN,23,1.28,1.93,104.68,-0.24*18\r\n"), Reason::bad_header) << "another sentence";
  EXPECT_EQ(reason("$PSXN,10,011,1.5x,-0.75,0.25*00\r\n"), Reason::bad_value);
  EXPECT_EQ(reason("$PSXN,10,011,,-0.75,0.25*00\r\n"), Reason::bad_value) << "nothing is told";
  EXPECT_EQ(reason("$PSXN,10,011,95,-0.75,0.25*00\r\n"), Reason::bad_value) << "upside down";
  EXPECT_EQ(reason("$PSXN,10,011,1.50,-0.75,0.25*3A"), Reason::too_short) << "no end";
  EXPECT_EQ(reason(std::string(2000, '$')), Reason::too_long);
  constexpr std::array kTime{Variable::system_time};
  const Layout time{.variables = VariableList::of(kTime).value(), .limits = {}};
  EXPECT_FALSE(reason("$PSXN,10,011,4294967295*00\r\n", time)) << "the checksum is judged elsewhere";
  EXPECT_EQ(reason("$PSXN,10,011,4294967296*00\r\n", time), Reason::bad_value);
}

TEST(MruFormats, EveryPrefixOfEveryGoldenDatagramIsRefused) {
  for (const Golden& golden : all_golden()) {
    for (std::size_t n = 0; n < golden.bytes.size(); ++n) {
      Decoder decoder{golden.format, golden.layout};
      EXPECT_FALSE(decoder.decode(Bytes{golden.bytes}.first(n)).ok()) << to_string(golden.format) << " " << n;
    }
  }
}

TEST(MruFormats, EveryGoldenDatagramIsRefusedByEveryOtherFormat) {
  for (const Golden& golden : all_golden()) {
    for (const Format format : kFormats) {
      Decoder decoder{format, golden.layout};
      const auto heard = decoder.decode(golden.bytes);
      EXPECT_EQ(heard.ok(), format == golden.format)
          << to_string(golden.format) << " as " << to_string(format);
    }
  }
}

TEST(MruFormats, GoldenDatagramsAreWrittenByteForByte) {
  std::array<std::uint8_t, kMaxDatagram> room{};
  EXPECT_TRUE(std::ranges::equal(*km::encode(*km::decode(kKmFrame), room), kKmFrame));
  EXPECT_TRUE(std::ranges::equal(*em3000::encode(*em3000::decode(kEm3000Frame), room), kEm3000Frame));
  EXPECT_TRUE(std::ranges::equal(*bin23::encode(*bin23::decode(kBin23Frame), room), kBin23Frame));
  for (const auto text : {kTss1Healy, kTss1Novatel}) {
    EXPECT_EQ(as_text(*tss1::encode(*tss1::decode(as_bytes(text)), room)), text);
  }
  const Layout layout = nmeap_layout();
  EXPECT_EQ(as_text(*nmeap::encode(nmeap::decode(kNmeap, layout)->frame, layout, room)), kNmeap);
  for (const auto text : {kPsxn20, kPsxn23, kPsxn23Level, kPsxn23Port, kPsxn24, kPrdid}) {
    EXPECT_EQ(as_text(*nmea::encode(*nmea::decode(text), room)), text);
  }
}

TEST(MruFormats, AMotionComesBackFromEveryFormatWithinItsResolution) {
  Random random{11};
  std::array<std::uint8_t, kRoomForAny> room{};
  for (const Format format : kFormats) {
    const bool coarse = format != Format::mrubin && format != Format::km_binary;
    const double angle = coarse ? 0.0101 * kDegree : 1e-6;
    const double length = coarse ? 0.0101 : 1e-5;
    Decoder decoder{format, {}};
    for (int i = 0; i < 500; ++i) {
      Motion sent;
      const auto draw = [&](double most) {
        return Motion::Triple{random.uniform(-most, most), random.uniform(-most, most),
                              random.uniform(-most, most)};
      };
      sent.euler_heading_mru_rad = draw(0.6);
      sent.euler_heading_mru_rad[2] = random.uniform(-3.1, 3.1);
      sent.omega_mru_radps = draw(0.5);
      sent.omega_down_radps = 0.1;
      sent.v_mru_mps = sent.a_mru_mps2 = draw(2.0);
      sent.p_heading_origin_m = draw(5.0);
      sent.v_heading_origin_mps = draw(3.0);
      sent.a_heading_origin_mps2 = draw(3.0);
      sent.sensor_temperature_degc = 30.0;
      const auto bytes = encode(sent, format, {}, ChecksumRule::ones_complement, 123456789ms, room);
      ASSERT_TRUE(bytes.ok());
      const auto heard = decoder.decode(*bytes);
      ASSERT_TRUE(heard.ok() && *heard) << to_string(format);
      const Motion& got = (*heard)->motion;
      EXPECT_TRUE(got.stable);
      const auto close = [&](const Motion::Triple& a, const Motion::Triple& b, double tolerance) {
        for (std::size_t k = 0; k < 3; ++k) {
          if (std::isnan(a[k])) continue;
          EXPECT_NEAR(a[k], b[k], tolerance) << to_string(format) << " " << k;
        }
      };
      close(got.euler_heading_mru_rad, sent.euler_heading_mru_rad, angle);
      close(got.omega_mru_radps, sent.omega_mru_radps, angle);
      close(got.p_heading_origin_m, sent.p_heading_origin_m, length);
      close(got.v_heading_origin_mps, sent.v_heading_origin_mps, length);
      close(got.a_heading_origin_mps2, sent.a_heading_origin_mps2, 1e-3);
    }
  }
}

TEST(MruFormats, RandomBytesAndRandomDamageAreSurvived) {
  Random random{5};
  for (const Golden& golden : all_golden()) {
    Decoder decoder{golden.format, golden.layout};
    for (int i = 0; i < 20000; ++i) {
      ByteBuffer bytes = golden.bytes;
      bytes[random.below(static_cast<std::uint32_t>(bytes.size()))] =
          static_cast<std::uint8_t>(random.bits());
      if (random.chance(0.1)) bytes.resize(random.below(300));
      const auto heard = decoder.decode(bytes);
      if (!heard || !*heard || has_list(golden.format)) continue;
      const Motion& motion = (*heard)->motion;
      ASSERT_TRUE(check_plausible(motion, {}).ok());
    }
  }
}

TEST(MruVariables, MayBeUnlistedWhenTheirTypeIsSaid) {
  const std::array variables{Variable::roll, static_cast<Variable>(226), static_cast<Variable>(900)};
  const std::array f32{static_cast<Variable>(226)};
  const std::array i32{static_cast<Variable>(900)};
  EXPECT_FALSE(VariableList::of(variables).ok());
  EXPECT_FALSE(VariableList::of(variables, f32).ok());
  const auto list = VariableList::of(variables, f32, i32);
  ASSERT_TRUE(list.ok());
  EXPECT_EQ((*list)[0].frame, "heading");
  EXPECT_EQ((*list)[1].type, ValueType::f32);
  EXPECT_EQ((*list)[2].type, ValueType::i32);
  EXPECT_EQ((*list)[2].quantity, Quantity::unlisted);
  const Layout layout{.variables = *list, .token = 7, .limits = {}};
  // Constructed: roll 0.02 rad, 1.0, -2.
  const std::array<std::uint8_t, 16> bytes{0x71, 0x0D, 0x07, 0x3C, 0xA3, 0xD7, 0x0A, 0x3F,
                                           0x80, 0x00, 0x00, 0xFF, 0xFF, 0xFF, 0xFE, 0x00};
  const auto frame = decode(bytes, layout);
  ASSERT_TRUE(frame.ok());
  EXPECT_NEAR(*frame->value(Variable::roll, layout), 0.02, 1e-9);
  EXPECT_EQ(frame->values[1], 1.0);
  EXPECT_EQ(frame->values[2], -2.0);
}

TEST(MruVariables, EveryListedOneHasAUnitAndAFrameWhereItNeedsOne) {
  const VariableList& list = VariableList::laboratory();
  for (std::size_t i = 0; i < list.size(); ++i) {
    EXPECT_FALSE(list[i].unit.empty()) << list[i].name;
    const bool scalar = list[i].quantity == Quantity::time || list[i].quantity == Quantity::temperature;
    EXPECT_EQ(list[i].frame.empty(), scalar) << list[i].name;
  }
}

}  // namespace
}  // namespace motionlab::mru
