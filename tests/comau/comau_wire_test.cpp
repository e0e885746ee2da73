#include "drivers/comau/comau_wire.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "drivers/core/random.hpp"
#include "tests/comau/comau_frames.hpp"

namespace motionlab::comau {
namespace {

TEST(ComauWire, DecodesTheConstructedCommand) {
  const auto command = decode_command(kCommandBytes);
  ASSERT_TRUE(command.ok());
  EXPECT_EQ(command->key, 32);
  EXPECT_EQ(command->mode, 1);
  EXPECT_EQ(command->qd_radps, (std::array{0.5F, -0.25F, 0.125F, 0.0F, 1.0F, -2.0F}));
  EXPECT_TRUE(check(*command).ok());
}

TEST(ComauWire, EncodesTheConstructedCommand) {
  Command command;
  command.mode = 1;
  command.qd_radps = {0.5F, -0.25F, 0.125F, 0.0F, 1.0F, -2.0F};
  EXPECT_EQ(encode(command), kCommandBytes);
}

TEST(ComauWire, DecodesTheConstructedAnswer) {
  const auto answer = decode_answer(kAnswerBytes);
  ASSERT_TRUE(answer.ok());
  EXPECT_EQ(answer->frame_counter, 0x01020304u);
  EXPECT_EQ(answer->q_rad, (Joints{0, 0.5, -1.5, 0.25, -0.125, 2}));
  EXPECT_EQ(answer->qd_radps, (Joints{0.0625, -0.5, 1, -1, 0, 0.25}));
}

const Answer kConstructed{0x01020304, {0, 0.5, -1.5, 0.25, -0.125, 2}, {0.0625, -0.5, 1, -1, 0, 0.25}};
const ReportedLimits kConstructedLimits{{-0.75, -0.5, -2.5, -0.125, -0.125, -0.25},
                                        {0.75, 0.5, -0.75, 0.125, 0.125, 0.25},
                                        {0.5, 0.5, 0.5, 0.0625, 0.0625, 4}};

TEST(ComauWire, EncodesTheConstructedAnswer) {
  EXPECT_TRUE(std::ranges::equal(encode(kConstructed), kAnswerBytes));
}

TEST(ComauWire, DecodesTheConstructedLongAnswer) {
  const auto bytes = long_answer_bytes();
  const auto answer = decode_answer(bytes);
  ASSERT_TRUE(answer.ok());
  EXPECT_EQ(answer->frame_counter, 0x01020304u);
  EXPECT_EQ(answer->q_rad, kConstructed.q_rad);
  EXPECT_EQ(answer->qd_radps, kConstructed.qd_radps);
  ASSERT_TRUE(answer->limits);
  EXPECT_EQ(*answer->limits, kConstructedLimits);
}

TEST(ComauWire, EncodesTheConstructedLongAnswer) {
  Answer answer = kConstructed;
  answer.limits = kConstructedLimits;
  EXPECT_TRUE(std::ranges::equal(encode(answer), long_answer_bytes()));
}

TEST(ComauWire, RefusesEveryPrefixOfTheConstructedDatagrams) {
  for (std::size_t n = 0; n < kCommandBytes.size(); ++n) {
    EXPECT_EQ(decode_command(Bytes{kCommandBytes}.first(n)).fault().reason, Reason::too_short) << n;
  }
  const auto longest = long_answer_bytes();
  for (std::size_t n = 0; n < longest.size(); ++n) {
    if (n == kAnswerSize) continue;  // is the short form whole
    EXPECT_EQ(decode_answer(Bytes{longest}.first(n)).fault().reason,
              n < kAnswerSize ? Reason::too_short : Reason::too_long)
        << n;
  }
}

TEST(ComauWire, RefusesEveryOtherSize) {
  const ByteBuffer bytes(200, 0);
  for (std::size_t n = 0; n <= bytes.size(); ++n) {
    const Bytes some = Bytes{bytes}.first(n);
    if (n != 32) {
      EXPECT_EQ(decode_command(some).fault().reason, n < 32 ? Reason::too_short : Reason::too_long);
    }
    if (n != 52 && n != 124) {
      EXPECT_EQ(decode_answer(some).fault().reason, n < 52 ? Reason::too_short : Reason::too_long);
    }
  }
}

TEST(ComauWire, RefusesALongAnswerWithALimitThatIsNotFinite) {
  for (std::size_t i = 0; i < 30; ++i) {
    for (const float bad :
         {std::numeric_limits<float>::quiet_NaN(), -std::numeric_limits<float>::infinity()}) {
      auto bytes = long_answer_bytes();
      store<std::endian::little>(MutableBytes{bytes}.subspan(4 + 4 * i, 4), bad);
      EXPECT_EQ(decode_answer(bytes).fault().reason, Reason::bad_value) << i;
    }
  }
}

TEST(ComauWire, RefusesAnAnswerThatIsNotFinite) {
  for (std::size_t i = 0; i < 12; ++i) {
    auto bytes = kAnswerBytes;
    store<std::endian::little>(MutableBytes{bytes}.subspan(4 + 4 * i, 4),
                               std::numeric_limits<float>::quiet_NaN());
    EXPECT_EQ(decode_answer(bytes).fault().reason, Reason::bad_value) << i;
    store<std::endian::little>(MutableBytes{bytes}.subspan(4 + 4 * i, 4),
                               std::numeric_limits<float>::infinity());
    EXPECT_EQ(decode_answer(bytes).fault().reason, Reason::bad_value) << i;
  }
}

TEST(ComauWire, ChecksKeyModeAndFiniteValuesOfACommand) {
  Command command;
  EXPECT_TRUE(check(command).ok());
  command.key = 33;
  EXPECT_EQ(check(command).fault().reason, Reason::bad_header);
  command = {};
  command.mode = 2;
  EXPECT_EQ(check(command).fault().reason, Reason::bad_header);
  command.mode = -1;
  EXPECT_EQ(check(command).fault().reason, Reason::bad_header);
  command = {};
  command.qd_radps[5] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(check(command).fault().reason, Reason::bad_value);
  command.qd_radps[5] = -std::numeric_limits<float>::infinity();
  EXPECT_EQ(check(command).fault().reason, Reason::bad_value);
}

TEST(ComauWire, SurvivesRandomBytesAndRepeatsWhatItAccepts) {
  Random random{11};
  for (int i = 0; i < 100000; ++i) {
    ByteBuffer bytes(random.chance(0.3)   ? 52
                     : random.chance(0.3) ? 124
                     : random.chance(0.5) ? 32
                                          : random.below(130));
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random.bits());
    if (const auto answer = decode_answer(bytes)) {
      ASSERT_TRUE(std::ranges::equal(encode(*answer), bytes));
    }
    if (const auto command = decode_command(bytes); command.ok() && check(*command).ok()) {
      const auto again = encode(*command);
      ASSERT_EQ(ByteBuffer(again.begin(), again.end()), bytes);
    }
  }
}

}  // namespace
}  // namespace motionlab::comau
