#include "drivers/plc_reply/plc_reply_wire.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <string>

#include "drivers/core/random.hpp"
#include "tests/plc_reply/plc_reply_frames.hpp"

namespace motionlab::plc_reply {
namespace {

/// What the constructed reply says as its `n`-th number, counted from 1.
double number(int n) {
  return (n % 2 == 1 ? 1.0 : -1.0) * n / 64.0;
}

Six six(int first) {
  Six values;
  for (int i = 0; i < 6; ++i) values[static_cast<std::size_t>(i)] = number(first + i);
  return values;
}

Reply constructed() {
  Reply reply;
  reply.mode = 0x01020304;
  reply.t_s = number(1);
  reply.q_rad = six(2);
  reply.qd_radps = six(8);
  reply.wire_length_m = number(14);
  reply.wire_speed_mps = number(15);
  reply.platforms = {{{six(16), six(22), six(28)}, {six(46), six(52), six(58)}}};
  reply.mrus = {{{six(34), six(40)}, {six(64), six(70)}}};
  return reply;
}

std::array<std::uint8_t, kReplySize> with(std::size_t offset, float value) {
  auto bytes = kReplyBytes;
  store<std::endian::little>(MutableBytes{bytes}.subspan(offset, 4), value);
  return bytes;
}

TEST(PlcReplyWire, DecodesTheConstructedReply) {
  const auto reply = decode_reply(kReplyBytes);
  ASSERT_TRUE(reply.ok());
  EXPECT_EQ(*reply, constructed());
}

TEST(PlcReplyWire, EncodesTheConstructedReply) {
  EXPECT_EQ(encode(constructed()), kReplyBytes);
}

TEST(PlcReplyWire, AsksWithNothingButZeros) {
  const auto request = decode_request(kRequest);
  ASSERT_TRUE(request.ok());
  EXPECT_NE(request->key, kControlKey);
  EXPECT_EQ(request->key, 0U);
  EXPECT_EQ(request->heartbeat, 0U);
  EXPECT_EQ(request->mode, 0U);
  EXPECT_TRUE(std::ranges::all_of(request->wanted, [](float value) { return value == 0.0F; }));
}

TEST(PlcReplyWire, ReadsWhatWouldTakeControl) {
  auto bytes = kRequest;  // constructed: the key is 0C 9D C5 02, the wire's speed is the last
  bytes[0] = 0x0C;
  bytes[1] = 0x9D;
  bytes[2] = 0xC5;
  bytes[3] = 0x02;
  bytes[4] = 7;
  bytes[8] = 1;
  bytes[134] = 0x80;
  bytes[135] = 0x3F;
  const auto request = decode_request(bytes);
  ASSERT_TRUE(request.ok());
  EXPECT_EQ(request->key, kControlKey);
  EXPECT_EQ(request->heartbeat, 7U);
  EXPECT_EQ(request->mode, 1U);
  EXPECT_EQ(request->wanted.back(), 1.0F);
}

TEST(PlcReplyWire, RefusesEveryOtherSize) {
  ByteBuffer bytes(400, 0);
  std::ranges::copy(kReplyBytes, bytes.begin());
  for (std::size_t n = 0; n <= bytes.size(); ++n) {
    const Bytes some = Bytes{bytes}.first(n);
    if (n != 136) {
      EXPECT_EQ(decode_request(some).fault().reason, n < 136 ? Reason::too_short : Reason::too_long) << n;
    }
    if (n != 304) {
      EXPECT_EQ(decode_reply(some).fault().reason, n < 304 ? Reason::too_short : Reason::too_long) << n;
    }
  }
}

TEST(PlcReplyWire, RefusesAReplyWithANumberThatIsNone) {
  using Limits = std::numeric_limits<float>;
  for (std::size_t offset = 4; offset < kReplySize; offset += 4) {
    for (const float bad : {Limits::quiet_NaN(), Limits::infinity(), -Limits::infinity()}) {
      EXPECT_EQ(decode_reply(with(offset, bad)).fault().reason, Reason::bad_value) << offset;
    }
  }
}

TEST(PlcReplyWire, RefusesWhatNoPlatformDoesAndNoUnitMeasures) {
  for (const std::size_t eta : {64U, 136U, 184U, 256U}) {
    for (const std::size_t axis : {0U, 1U, 2U}) {
      EXPECT_TRUE(decode_reply(with(eta + 4 * axis, -10.0F)).ok());
      EXPECT_EQ(decode_reply(with(eta + 4 * axis, 10.01F)).fault().reason, Reason::bad_value) << eta;
    }
    for (const std::size_t axis : {3U, 4U}) {
      EXPECT_TRUE(decode_reply(with(eta + 4 * axis, 1.57F)).ok());
      EXPECT_EQ(decode_reply(with(eta + 4 * axis, -1.58F)).fault().reason, Reason::bad_value) << eta;
    }
    EXPECT_TRUE(decode_reply(with(eta + 4 * 5, 6.0F)).ok()) << "a heading goes round";
  }
  for (const std::size_t v : {160U, 280U}) {
    EXPECT_EQ(decode_reply(with(v, 10.5F)).fault().reason, Reason::bad_value);
    EXPECT_EQ(decode_reply(with(v + 20, -10.5F)).fault().reason, Reason::bad_value);
  }
  EXPECT_TRUE(decode_reply(with(8, 1e6F)).ok()) << "the joints are nobody's business here";
}

TEST(PlcReplyWire, TakesNoRandomBytesForAReply) {
  Random random{5};
  std::array<std::uint8_t, kReplySize> bytes{};
  for (int i = 0; i < 20000; ++i) {
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random.bits());
    EXPECT_FALSE(decode_reply(bytes).ok());
  }
}

}  // namespace
}  // namespace motionlab::plc_reply
