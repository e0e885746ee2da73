// The ADS codec against frames that other people's programs made, and against every way a frame can be wrong.
#include "drivers/winch/winch_wire.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "drivers/core/error.hpp"
#include "drivers/core/random.hpp"

namespace motionlab::winch {
namespace {

// Published: captured between ads-client 2.1.0 and ads-server, decoded by tshark's AMS dissector.
constexpr std::array<std::uint8_t, 58> kWriteByHandle = {
    0x00, 0x00, 0x34, 0x00, 0x00, 0x00,                                      // AMS/TCP: length 52
    0x0a, 0x00, 0x00, 0x02, 0x01, 0x01, 0x53, 0x03,                          // target 10.0.0.2.1.1 : 851
    0x0a, 0x00, 0x00, 0x01, 0x01, 0x01, 0xee, 0x7f,                          // source 10.0.0.1.1.1 : 32750
    0x03, 0x00, 0x04, 0x00, 0x14, 0x00, 0x00, 0x00,                          // Write, request, 20 bytes
    0x00, 0x00, 0x00, 0x00, 0x01, 0x00, 0x00, 0x00,                          // AMS error 0, invoke id 1
    0x05, 0xf0, 0x00, 0x00, 0x00, 0x10, 0x00, 0x00, 0x08, 0x00, 0x00, 0x00,  // 0xF005, handle 0x1000, 8 bytes
    0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0xd0, 0x3f,                          // 0.25
};
constexpr std::array<std::uint8_t, 42> kWriteReply = {
    0x00, 0x00, 0x24, 0x00, 0x00, 0x00, 0x0a, 0x00, 0x00, 0x01, 0x01, 0x01, 0xee, 0x7f,
    0x0a, 0x00, 0x00, 0x02, 0x01, 0x01, 0x53, 0x03, 0x03, 0x00, 0x05, 0x00, 0x04, 0x00,
    0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x01, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
};
constexpr std::array<std::uint8_t, 70> kNotification = {
    0x00, 0x00, 0x40, 0x00, 0x00, 0x00, 0x0a, 0x00, 0x00, 0x01, 0x01, 0x01, 0xee,
    0x7f, 0x0a, 0x00, 0x00, 0x02, 0x01, 0x01, 0x53, 0x03, 0x08, 0x00, 0x04, 0x00,
    0x20, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,  // invoke id 0
    0x1c, 0x00, 0x00, 0x00, 0x01, 0x00, 0x00, 0x00,                          // 28 bytes follow, 1 stamp
    0xd0, 0x59, 0x1b, 0xef, 0x12, 0x7a, 0xdd, 0x01, 0x01, 0x00, 0x00, 0x00,  // 2026-11-21 23:49:23.053 UTC
    0x01, 0x00, 0x00, 0x00, 0x04, 0x00, 0x00, 0x00, 0x58, 0x00, 0x00, 0x00,  // handle 1, 4 bytes, 88
};

const AmsAddress kClient{{{10, 0, 0, 1, 1, 1}}, 32750};
const AmsAddress kServer{{{10, 0, 0, 2, 1, 1}}, 851};

Bytes body_of(Bytes frame) {
  return frame.subspan(kTcpHeaderSize);
}

std::vector<std::uint8_t> copy(Bytes bytes) {
  return {bytes.begin(), bytes.end()};
}

template <class Message>
std::vector<std::uint8_t> encoded(const Message& message) {
  std::array<std::uint8_t, 4096> buffer{};
  LittleWriter writer{buffer};
  message.encode(writer);
  EXPECT_TRUE(writer.ok());
  return copy(writer.written());
}

TEST(WinchWire, DecodesThePublishedWriteByHandle) {
  const auto frame = decode_ams(body_of(kWriteByHandle));
  ASSERT_TRUE(frame.ok());
  EXPECT_EQ(frame->header, (AmsHeader{kServer, kClient, 3, 0x0004, 0, 1}));
  EXPECT_FALSE(frame->header.is_response());
  const auto request = WriteRequest::decode(frame->data);
  ASSERT_TRUE(request.ok());
  EXPECT_EQ(request->index_group, 0xF005U);
  EXPECT_EQ(request->index_offset, 0x1000U);
  ASSERT_EQ(request->data.size(), 8U);
  EXPECT_EQ((load<double, std::endian::little>(request->data)), 0.25);
}

TEST(WinchWire, EncodesThePublishedWriteByHandleByteForByte) {
  std::array<std::uint8_t, 8> value{};
  store<std::endian::little>(value, 0.25);
  std::array<std::uint8_t, 128> buffer{};
  const auto frame = encode_frame(buffer, AmsHeader{kServer, kClient, 3, kRequestFlags, 0, 1},
                                  WriteRequest{0xF005, 0x1000, value});
  ASSERT_TRUE(frame.ok());
  EXPECT_TRUE(std::equal(frame->begin(), frame->end(), kWriteByHandle.begin(), kWriteByHandle.end()));
}

TEST(WinchWire, DecodesAndEncodesThePublishedReply) {
  const auto frame = decode_ams(body_of(kWriteReply));
  ASSERT_TRUE(frame.ok());
  EXPECT_TRUE(frame->header.is_response());
  const auto request = decode_ams(body_of(kWriteByHandle));
  EXPECT_EQ(frame->header, request->header.reply());
  const auto response = ResultResponse::decode(frame->data);
  ASSERT_TRUE(response.ok());
  EXPECT_EQ(response->result, 0U);

  std::array<std::uint8_t, 128> buffer{};
  const auto again = encode_frame(buffer, request->header.reply(), ResultResponse{0});
  ASSERT_TRUE(again.ok());
  EXPECT_TRUE(std::equal(again->begin(), again->end(), kWriteReply.begin(), kWriteReply.end()));
}

TEST(WinchWire, DecodesThePublishedNotification) {
  const auto frame = decode_ams(body_of(kNotification));
  ASSERT_TRUE(frame.ok());
  EXPECT_EQ(frame->header, (AmsHeader{kClient, kServer, 8, 0x0004, 0, 0}));
  auto reader = NotificationReader::open(frame->data);
  ASSERT_TRUE(reader.ok());
  NotificationReader samples = *reader;
  const auto item = samples.next();
  ASSERT_TRUE(item.has_value());
  EXPECT_EQ(item->sample.handle, 1U);
  ASSERT_EQ(item->sample.data.size(), 4U);
  EXPECT_EQ((load<std::uint32_t, std::endian::little>(item->sample.data)), 88U);
  const auto t = since_1970(item->filetime);
  ASSERT_TRUE(t.has_value());
  constexpr std::int64_t kSecondsTo20261121T234923 = 1795304963;
  EXPECT_EQ(t->count(), kSecondsTo20261121T234923 * 1'000'000'000 + 53'000'000);
  EXPECT_FALSE(samples.next().has_value());
}

TEST(WinchWire, EncodesThePublishedNotificationByteForByte) {
  const std::array<std::uint8_t, 4> value = {0x58, 0, 0, 0};
  const NotificationSample sample{1, value};
  const NotificationStamp stamp{0x01dd7a12ef1b59d0, {&sample, 1}};
  std::array<std::uint8_t, 128> buffer{};
  const auto frame = encode_frame(buffer, AmsHeader{kClient, kServer, 8, kRequestFlags, 0, 0},
                                  NotificationStream{{&stamp, 1}});
  ASSERT_TRUE(frame.ok());
  EXPECT_TRUE(std::equal(frame->begin(), frame->end(), kNotification.begin(), kNotification.end()));
}

// Constructed.
TEST(WinchWire, WalksThroughSeveralStampsAndSamplesOfOneFrame) {
  const std::array<std::uint8_t, 3> a = {1, 2, 3};
  const std::array<std::uint8_t, 1> b = {9};
  const std::array<NotificationSample, 2> first = {NotificationSample{7, a}, NotificationSample{8, {}}};
  const std::array<NotificationSample, 1> second = {NotificationSample{9, b}};
  const std::array<NotificationStamp, 3> stamps = {NotificationStamp{100, first}, NotificationStamp{150, {}},
                                                   NotificationStamp{200, second}};
  const auto bytes = encoded(NotificationStream{stamps});
  auto opened = NotificationReader::open(bytes);
  ASSERT_TRUE(opened.ok());
  NotificationReader reader = *opened;
  auto item = reader.next();
  ASSERT_TRUE(item);
  EXPECT_EQ(item->filetime, 100U);
  EXPECT_EQ(item->sample.handle, 7U);
  EXPECT_EQ(copy(item->sample.data), (std::vector<std::uint8_t>{1, 2, 3}));
  item = reader.next();
  ASSERT_TRUE(item);
  EXPECT_EQ(item->sample.handle, 8U);
  EXPECT_TRUE(item->sample.data.empty());
  item = reader.next();
  ASSERT_TRUE(item);
  EXPECT_EQ(item->filetime, 200U);
  EXPECT_EQ(item->sample.handle, 9U);
  EXPECT_FALSE(reader.next());
}

TEST(WinchWire, RefusesANotificationStreamThatDoesNotAddUp) {
  const auto good = copy(Bytes{kNotification}.subspan(kFrameHeaderSize));
  const auto reason = [](std::vector<std::uint8_t> bytes) {
    const auto opened = NotificationReader::open(bytes);
    return opened.ok() ? Reason::count_ : opened.fault().reason;
  };
  EXPECT_EQ(reason(good), Reason::count_);
  EXPECT_EQ(reason({}), Reason::too_short);
  auto wrong_length = good;
  wrong_length[0] = 0x20;  // what an old server does: the length counts itself
  EXPECT_EQ(reason(wrong_length), Reason::bad_header);
  auto many_stamps = good;
  for (int i = 4; i < 8; ++i) many_stamps[static_cast<std::size_t>(i)] = 0xff;
  EXPECT_EQ(reason(many_stamps), Reason::too_short);
  auto many_samples = good;
  for (int i = 16; i < 20; ++i) many_samples[static_cast<std::size_t>(i)] = 0xff;
  EXPECT_EQ(reason(many_samples), Reason::too_short);
  auto long_sample = good;
  long_sample[24] = 5;
  EXPECT_EQ(reason(long_sample), Reason::too_short);
  auto short_sample = good;
  short_sample[24] = 3;
  EXPECT_EQ(reason(short_sample), Reason::too_long);
}

TEST(WinchWire, RefusesAnAmsHeaderWhoseLengthLies) {
  auto body = copy(body_of(kWriteByHandle));
  EXPECT_EQ(decode_ams(Bytes{body}.first(31)).fault().reason, Reason::too_short);
  body[20] = 21;
  EXPECT_EQ(decode_ams(body).fault().reason, Reason::too_short);
  body[20] = 19;
  EXPECT_EQ(decode_ams(body).fault().reason, Reason::too_long);
}

TEST(WinchWire, SaysWhenAFrameDoesNotFit) {
  std::array<std::uint8_t, 57> buffer{};
  const std::array<std::uint8_t, 8> value{};
  const auto frame = encode_frame(buffer, AmsHeader{}, WriteRequest{1, 2, value});
  ASSERT_FALSE(frame.ok());
  EXPECT_EQ(frame.fault().reason, Reason::too_long);
  EXPECT_FALSE(encode_tcp_frame(MutableBytes{buffer}.first(7), TcpCommand::port_connect, value).ok());
}

// Constructed from the tables of the ADS specification.
TEST(WinchWire, LaysOutEveryRequestAsSpecified) {
  using V = std::vector<std::uint8_t>;
  EXPECT_EQ(encoded(ReadRequest{0xF005, 0x1000, 4}), (V{0x05, 0xf0, 0, 0, 0, 0x10, 0, 0, 4, 0, 0, 0}));
  const std::array<std::uint8_t, 2> ab = {'a', 'b'};
  EXPECT_EQ(encoded(ReadWriteRequest{0xF003, 0, 4, ab}),
            (V{0x03, 0xf0, 0, 0, 0, 0, 0, 0, 4, 0, 0, 0, 2, 0, 0, 0, 'a', 'b'}));
  EXPECT_EQ(encoded(WriteControlRequest{AdsState::stop, 1, ab}), (V{6, 0, 1, 0, 2, 0, 0, 0, 'a', 'b'}));
  EXPECT_EQ(encoded(DeleteNotificationRequest{0x01020304}), (V{4, 3, 2, 1}));
  const auto add = encoded(AddNotificationRequest{0xF005, 1, 120, 3, 0ms, 10ms});
  ASSERT_EQ(add.size(), 40U);
  EXPECT_EQ(V(add.begin() + 8, add.begin() + 16), (V{120, 0, 0, 0, 3, 0, 0, 0}));
  EXPECT_EQ(V(add.begin() + 20, add.begin() + 24), (V{0xa0, 0x86, 0x01, 0x00}));  // 100 000 x 100 ns
}

TEST(WinchWire, LaysOutEveryResponseAsSpecified) {
  using V = std::vector<std::uint8_t>;
  EXPECT_EQ(encoded(ReadStateResponse{0, AdsState::run, 0}), (V{0, 0, 0, 0, 5, 0, 0, 0}));
  EXPECT_EQ(encoded(AddNotificationResponse{0, 7}), (V{0, 0, 0, 0, 7, 0, 0, 0}));
  EXPECT_EQ(encoded(ReadResponse{0x710, {}}), (V{0x10, 7, 0, 0, 0, 0, 0, 0}));
  EXPECT_EQ(
      encoded(DeviceInfoResponse{0, 3, 1, 4022, "Plc30 App"}),
      (V{0, 0, 0, 0, 3, 1, 0xb6, 0x0f, 'P', 'l', 'c', '3', '0', ' ', 'A', 'p', 'p', 0, 0, 0, 0, 0, 0, 0}));
}

template <class Message>
void refuses_other_sizes(std::vector<std::uint8_t> bytes) {
  EXPECT_TRUE(Message::decode(bytes).ok());
  bytes.push_back(0);
  ASSERT_FALSE(Message::decode(bytes).ok());
  EXPECT_EQ(Message::decode(bytes).fault().reason, Reason::too_long);
  for (std::size_t n = 0; n + 1 < bytes.size(); ++n) {
    const auto cut = Message::decode(Bytes{bytes}.first(n));
    ASSERT_FALSE(cut.ok()) << n;
    EXPECT_EQ(cut.fault().reason, Reason::too_short) << n;
  }
}

TEST(WinchWire, RefusesEveryMessageOneByteShortOrLong) {
  const std::array<std::uint8_t, 3> data = {1, 2, 3};
  refuses_other_sizes<ReadRequest>(encoded(ReadRequest{1, 2, 3}));
  refuses_other_sizes<WriteRequest>(encoded(WriteRequest{1, 2, data}));
  refuses_other_sizes<ReadWriteRequest>(encoded(ReadWriteRequest{1, 2, 3, data}));
  refuses_other_sizes<WriteControlRequest>(encoded(WriteControlRequest{AdsState::run, 0, data}));
  refuses_other_sizes<AddNotificationRequest>(encoded(AddNotificationRequest{1, 2, 3, 4, 0ms, 1ms}));
  refuses_other_sizes<DeleteNotificationRequest>(encoded(DeleteNotificationRequest{1}));
  refuses_other_sizes<ResultResponse>(encoded(ResultResponse{0}));
  refuses_other_sizes<ReadResponse>(encoded(ReadResponse{0, data}));
  refuses_other_sizes<ReadStateResponse>(encoded(ReadStateResponse{0, AdsState::run, 0}));
  refuses_other_sizes<DeviceInfoResponse>(encoded(DeviceInfoResponse{0, 1, 2, 3, "x"}));
  refuses_other_sizes<AddNotificationResponse>(encoded(AddNotificationResponse{0, 1}));
  refuses_other_sizes<SymbolPlace>(encoded(SymbolPlace{1, 2, 3}));
}

TEST(WinchWire, AcceptsABareErrorAsResponse) {
  const std::array<std::uint8_t, 4> bare = {0x10, 0x07, 0, 0};
  EXPECT_EQ(ReadResponse::decode(bare)->result, 0x710U);
  EXPECT_EQ(ReadStateResponse::decode(bare)->result, 0x710U);
  EXPECT_EQ(AddNotificationResponse::decode(bare)->result, 0x710U);
  EXPECT_EQ(DeviceInfoResponse::decode(bare)->result, 0x710U);
}

TEST(WinchWire, RoundTripsASymbolEntryOfExactlyItsLength) {
  const SymbolEntry entry{{0x4040, 64, 120},    DataType::structure, 8,
                          "GVL_Winch.stStatus", "ST_WinchStatus",    ""};
  const auto bytes = encoded(entry);
  ASSERT_EQ(bytes.size(), 30U + 19U + 15U + 1U);
  EXPECT_EQ(bytes[0], bytes.size());
  const auto decoded = SymbolEntry::decode(bytes);
  ASSERT_TRUE(decoded.ok());
  EXPECT_EQ(*decoded, entry);
  auto longer = bytes;
  longer.push_back(0);
  EXPECT_EQ(SymbolEntry::decode(longer).fault().reason, Reason::bad_header);
  EXPECT_EQ(SymbolEntry::decode(Bytes{bytes}.first(40)).fault().reason, Reason::too_short);
}

TEST(WinchWire, TakesNamesWithAndWithoutNulInAnyCase) {
  EXPECT_EQ(symbol_name(as_bytes({"abc\0", 4})), "abc");
  EXPECT_EQ(symbol_name(as_bytes("abc")), "abc");
  EXPECT_TRUE(same_name("GVL_Winch.stStatus", "gvl_winch.STSTATUS"));
  EXPECT_FALSE(same_name("GVL_Winch", "GVL_Winch2"));
}

TEST(WinchWire, ParsesANetIdOrSaysHowToWriteOne) {
  EXPECT_EQ(NetId::parse("192.168.90.150.1.1"), (NetId{{192, 168, 90, 150, 1, 1}}));
  EXPECT_EQ(to_string(NetId{{1, 2, 3, 4, 5, 6}}), "1.2.3.4.5.6");
  for (const char* wrong :
       {"", "1.2.3.4.5", "1.2.3.4.5.6.7", "1.2.3.4.5.256", "1.2.3.4.5.x", "1,2,3,4,5,6"}) {
    EXPECT_THROW((void)NetId::parse(wrong), StartupError) << wrong;
  }
}

TEST(WinchWire, KnowsWhatToDoAboutEachError) {
  EXPECT_EQ(describe(6).error_class, ErrorClass::offline);
  EXPECT_EQ(describe(7).error_class, ErrorClass::configuration);
  EXPECT_EQ(describe(4).error_class, ErrorClass::back_off);
  EXPECT_EQ(describe(1793).name, "service not supported");
  EXPECT_EQ(describe(1797).error_class, ErrorClass::layout);
  EXPECT_EQ(describe(1808).error_class, ErrorClass::wrong_project);
  EXPECT_EQ(describe(1809).error_class, ErrorClass::resolve_again);
  EXPECT_EQ(describe(1810).error_class, ErrorClass::not_running);
  EXPECT_EQ(describe(1812).error_class, ErrorClass::subscribe_again);
  EXPECT_EQ(describe(0xABCD).error_class, ErrorClass::unknown);
}

TEST(WinchWire, ConvertsFiletimeWithinItsRange) {
  EXPECT_EQ(since_1970(kFiletimeOf1970), Nanoseconds{0});
  EXPECT_EQ(since_1970(kFiletimeOf1970 + 1), Nanoseconds{100});
  EXPECT_FALSE(since_1970(0).has_value());
  EXPECT_FALSE(since_1970(kFiletimeOf1970 - 1).has_value());
  EXPECT_FALSE(since_1970(std::numeric_limits<std::uint64_t>::max()).has_value());
  EXPECT_EQ(to_filetime(Nanoseconds{199}), kFiletimeOf1970 + 1);
}

// The splitter

TEST(WinchFrameSplitter, FindsTheSameFramesHoweverTheStreamIsCut) {
  std::vector<std::uint8_t> stream = copy(kWriteByHandle);
  stream.insert(stream.end(), kWriteReply.begin(), kWriteReply.end());
  stream.insert(stream.end(), kNotification.begin(), kNotification.end());
  for (std::size_t first = 0; first <= stream.size(); ++first) {
    for (std::size_t second : {first, std::min(first + 7, stream.size())}) {
      FrameSplitter splitter;
      std::vector<std::size_t> sizes;
      const auto feed = [&](std::size_t from, std::size_t to) {
        splitter.append(Bytes{stream}.subspan(from, to - from));
        while (true) {
          const auto next = splitter.next();
          ASSERT_TRUE(next.ok());
          if (!*next) break;
          sizes.push_back((**next).body.size());
        }
      };
      feed(0, first);
      feed(first, second);
      feed(second, stream.size());
      EXPECT_EQ(sizes, (std::vector<std::size_t>{52, 36, 64})) << first;
    }
  }
}

Reason splitter_reason(std::vector<std::uint8_t> header, std::size_t body_max = kBodySizeMax) {
  FrameSplitter splitter{body_max};
  splitter.append(header);
  const auto next = splitter.next();
  if (next.ok()) return Reason::count_;
  EXPECT_FALSE(splitter.next().ok()) << "a broken stream stays broken";
  splitter.append(kWriteReply);
  EXPECT_FALSE(splitter.next().ok());
  splitter.reset();
  splitter.append(kWriteReply);
  EXPECT_TRUE(splitter.next().ok());
  return next.fault().reason;
}

TEST(WinchFrameSplitter, RefusesLengthsThatNoFrameHas) {
  EXPECT_EQ(splitter_reason({0, 0, 31, 0, 0, 0}), Reason::too_short);
  EXPECT_EQ(splitter_reason({0, 0, 32, 0, 0, 0}), Reason::count_);
  EXPECT_EQ(splitter_reason({0, 0, 0, 0, 0x10, 0}), Reason::count_);    // exactly 1 MiB
  EXPECT_EQ(splitter_reason({0, 0, 1, 0, 0x10, 0}), Reason::too_long);  // one more
  EXPECT_EQ(splitter_reason({0, 0, 0xff, 0xff, 0xff, 0xff}), Reason::too_long);
  EXPECT_EQ(splitter_reason({0, 0, 101, 0, 0, 0}, 100), Reason::too_long);
  EXPECT_EQ(splitter_reason({0x47, 0x45, 0x54, 0x20, 0x2f, 0x20}), Reason::bad_header);  // "GET / "
  EXPECT_EQ(splitter_reason({0x00, 0x10, 2, 0, 0, 0}), Reason::count_);
  EXPECT_EQ(splitter_reason({0x00, 0x10, 65, 0, 0, 0}), Reason::too_long);
}

// The structs

TEST(WinchStructs, LayOutTheCommandAtItsLiteralOffsets) {
  PlcCommand command;
  command.heartbeat = 0x11121314;
  command.sequence = 0x21222324;
  command.position_m = 0.25;
  command.velocity_mps = -0.5;
  command.acceleration_mps2 = 1.0;
  command.torque_limit_nm = 2.0;
  command.mode = PlcMode::velocity;
  command.enable = true;
  command.reset = false;
  command.quick_stop = true;
  command.timeout = std::chrono::milliseconds{100};
  const std::vector<std::uint8_t> expected = {
      1,    0,    0,    0,                       //  0 nLayoutVersion
      0x14, 0x13, 0x12, 0x11,                    //  4 nHeartbeat
      0x24, 0x23, 0x22, 0x21,                    //  8 nSequence
      0,    0,    0,    0,                       // 12 reserved
      0,    0,    0,    0,    0, 0, 0xd0, 0x3f,  // 16 fSetPosition 0.25
      0,    0,    0,    0,    0, 0, 0xe0, 0xbf,  // 24 fSetVelocity -0.5
      0,    0,    0,    0,    0, 0, 0xf0, 0x3f,  // 32 fSetAcceleration 1
      0,    0,    0,    0,    0, 0, 0x00, 0x40,  // 40 fTorqueLimit 2
      2,    0,                                   // 48 eMode
      1,    0,    1,    0,                       // 50 bEnable, bReset, bQuickStop, reserved
      0,    0,                                   // 54 reserved
      100,  0,    0,    0,                       // 56 nTimeoutMs
      0,    0,    0,    0,                       // 60 reserved
  };
  EXPECT_EQ(encoded(command), expected);
  const auto decoded = PlcCommand::decode(expected);
  ASSERT_TRUE(decoded.ok());
  EXPECT_EQ(*decoded, command);
}

std::vector<std::uint8_t> literal_status() {
  return {
      1,    0,    0,    0,  //   0 nLayoutVersion
      2,    0,    0,    0,  //   4 nCycleCount
      3,    0,    0,    0,  //   8 nHeartbeatEcho
      4,    0,    0,    0,  //  12 nSequenceEcho
      0xd0, 0x59, 0x1b, 0xef,
      0x12, 0x7a, 0xdd, 0x01,  // 16 nTimestamp, 2026-11-21 23:49:23.053 UTC
      0,    0,    0,    0,
      0,    0,    0xd0, 0x3f,  // 24 fActPosition 0.25
      0,    0,    0,    0,
      0,    0,    0xe0, 0xbf,  // 32 fActVelocity -0.5
      0,    0,    0,    0,
      0,    0,    0xe0, 0x3f,  // 40 fSetPosition 0.5
      0,    0,    0,    0,
      0,    0,    0xd0, 0x3f,  // 48 fFollowingError 0.25
      0,    0,    0,    0,
      0,    0,    0xf8, 0x7f,  // 56 fActTorque NaN
      0,    0,    0,    0,
      0,    0,    0x44, 0x40,  // 64 fMotorTemperature 40
      0,    0,    0,    0,
      0,    0,    0,    0,  // 72 fMinPosition 0
      0,    0,    0,    0,
      0,    0,    0xf8, 0x3f,  // 80 fMaxPosition 1.5
      5,    0,    0,    0x80,  // 88 nAxisStateDWord
      0x50, 0x46, 0,    0,     // 92 nAxisErrorId
      0x11, 0xf0, 0,    0,     // 96 nDriveDiagCode
      6,    0,    0,    0,     // 100 nWatchdogTrips
      0,    0xc0,              // 104 nDriveStatusWord
      1,    0x80,              // 106 nClass1Diag
      7,    0,                 // 108 eState
      0,    0,                 // 110 reserved
      1,    0,    1,    0,
      2,    0,    1,    0,  // 112 bReady, bEnabled, bError, bWarning, bCommOk, bHomed, limits
  };
}

TEST(WinchStructs, ReadTheStatusFromItsLiteralOffsets) {
  const auto bytes = literal_status();
  ASSERT_EQ(bytes.size(), 120U);
  const auto status = PlcStatus::decode(bytes);
  ASSERT_TRUE(status.ok());
  EXPECT_EQ(status->cycle_count, 2U);
  EXPECT_EQ(status->heartbeat_echo, 3U);
  EXPECT_EQ(status->sequence_echo, 4U);
  EXPECT_EQ(status->t_plc.count(), 1795304963'053'000'000);
  EXPECT_EQ(status->position_m, 0.25);
  EXPECT_EQ(status->velocity_mps, -0.5);
  EXPECT_EQ(status->set_position_m, 0.5);
  EXPECT_EQ(status->following_error_m, 0.25);
  EXPECT_TRUE(std::isnan(status->torque_nm));
  EXPECT_EQ(status->motor_temperature_degc, 40.0);
  EXPECT_EQ(status->position_min_m, 0.0);
  EXPECT_EQ(status->position_max_m, 1.5);
  EXPECT_EQ(status->axis_state, 0x80000005U);
  EXPECT_EQ(status->axis_error_id, 0x4650U);
  EXPECT_EQ(status->drive_diagnosis, 0xF011U);
  EXPECT_EQ(status->watchdog_trips, 6U);
  EXPECT_EQ(status->drive_status_word, 0xC000U);
  EXPECT_EQ(status->class_1_diagnosis, 0x8001U);
  EXPECT_EQ(status->state, PlcState::communication_lost);
  EXPECT_TRUE(status->ready);
  EXPECT_FALSE(status->enabled);
  EXPECT_TRUE(status->error);
  EXPECT_FALSE(status->warning);
  EXPECT_TRUE(status->communication_ok) << "any BOOL that is not zero is true";
  EXPECT_FALSE(status->homed);
  EXPECT_TRUE(status->at_min);
  EXPECT_FALSE(status->at_max);
  auto canonical = bytes;
  canonical[116] = 1;
  EXPECT_EQ(encoded(*status), canonical);
}

template <class Struct>
Reason reason_with(std::vector<std::uint8_t> bytes, std::size_t at, std::vector<std::uint8_t> patch) {
  std::copy(patch.begin(), patch.end(), bytes.begin() + static_cast<std::ptrdiff_t>(at));
  const auto decoded = Struct::decode(bytes);
  return decoded.ok() ? Reason::count_ : decoded.fault().reason;
}

const std::vector<std::uint8_t> kNan = {0, 0, 0, 0, 0, 0, 0xf8, 0x7f};
const std::vector<std::uint8_t> kInfinity = {0, 0, 0, 0, 0, 0, 0xf0, 0x7f};

TEST(WinchStructs, RefuseACommandThatIsNotOneOfOurs) {
  const auto good = encoded(PlcCommand{});
  EXPECT_EQ(PlcCommand::decode(Bytes{good}.first(63)).fault().reason, Reason::too_short);
  auto longer = good;
  longer.push_back(0);
  EXPECT_EQ(PlcCommand::decode(longer).fault().reason, Reason::too_long);
  EXPECT_EQ(reason_with<PlcCommand>(good, 0, {2}), Reason::bad_header);
  for (const std::size_t at : {16U, 24U, 32U, 40U}) {
    EXPECT_EQ(reason_with<PlcCommand>(good, at, kNan), Reason::bad_value) << at;
    EXPECT_EQ(reason_with<PlcCommand>(good, at, kInfinity), Reason::bad_value) << at;
  }
  EXPECT_EQ(reason_with<PlcCommand>(good, 40, {0, 0, 0, 0, 0, 0, 0xf0, 0xbf}),
            Reason::bad_value);  // torque -1
  EXPECT_EQ(reason_with<PlcCommand>(good, 48, {4}), Reason::bad_value);
}

TEST(WinchStructs, RefuseAStatusThatIsNotOneOfOurs) {
  const auto good = literal_status();
  EXPECT_EQ(PlcStatus::decode(Bytes{good}.first(119)).fault().reason, Reason::too_short);
  auto longer = good;
  longer.push_back(0);
  EXPECT_EQ(PlcStatus::decode(longer).fault().reason, Reason::too_long);
  EXPECT_EQ(reason_with<PlcStatus>(good, 0, {0}), Reason::bad_header);
  EXPECT_EQ(reason_with<PlcStatus>(good, 16, {0, 0, 0, 0, 0, 0, 0, 0}), Reason::bad_value);
  for (const std::size_t at : {24U, 32U, 40U, 48U, 72U, 80U}) {
    EXPECT_EQ(reason_with<PlcStatus>(good, at, kNan), Reason::bad_value) << at;
  }
  for (const std::size_t at : {56U, 64U}) {
    EXPECT_EQ(reason_with<PlcStatus>(good, at, kNan), Reason::count_) << at;
    EXPECT_EQ(reason_with<PlcStatus>(good, at, kInfinity), Reason::bad_value) << at;
  }
  EXPECT_EQ(reason_with<PlcStatus>(good, 80, {0, 0, 0, 0, 0, 0, 0xf0, 0xbf}),
            Reason::bad_value);  // max -1 < min
  EXPECT_EQ(reason_with<PlcStatus>(good, 108, {8}), Reason::bad_value);
}

TEST(WinchStructs, NameEveryMemberAtItsOffset) {
  const auto offset_of = [](std::span<const Member> members, std::string_view name) {
    const auto found =
        std::find_if(members.begin(), members.end(), [&](const Member& m) { return m.name == name; });
    return found == members.end() ? 9999U : found->offset;
  };
  EXPECT_EQ(offset_of(command_members(), "fSetVelocity"), 24U);
  EXPECT_EQ(offset_of(command_members(), "bQuickStop"), 52U);
  EXPECT_EQ(offset_of(command_members(), "nTimeoutMs"), 56U);
  EXPECT_EQ(offset_of(status_members(), "nTimestamp"), 16U);
  EXPECT_EQ(offset_of(status_members(), "fMaxPosition"), 80U);
  EXPECT_EQ(offset_of(status_members(), "bLimitMax"), 119U);
}

TEST(WinchWire, RefusesEveryPrefixOfEveryPublishedFrame) {
  const auto refused = [](Bytes frame) {
    for (std::size_t n = 0; n < frame.size(); ++n) {
      FrameSplitter splitter;
      splitter.append(frame.first(n));
      const auto next = splitter.next();
      EXPECT_TRUE(next.ok() && !next->has_value()) << n << ": it waits for the rest";
      const std::size_t body = std::max(n, kTcpHeaderSize) - kTcpHeaderSize;
      EXPECT_FALSE(decode_ams(frame.subspan(kTcpHeaderSize, body)).ok()) << n;
    }
  };
  refused(kWriteByHandle);
  refused(kWriteReply);
  refused(kNotification);
  const Bytes write = Bytes{kWriteByHandle}.subspan(kFrameHeaderSize);
  for (std::size_t n = 0; n < write.size(); ++n) EXPECT_FALSE(WriteRequest::decode(write.first(n)).ok());
  const Bytes stream = Bytes{kNotification}.subspan(kFrameHeaderSize);
  for (std::size_t n = 0; n < stream.size(); ++n)
    EXPECT_FALSE(NotificationReader::open(stream.first(n)).ok());
}

TEST(WinchWire, SurvivesRandomBytesAndRandomlyDamagedFrames) {
  Random random{7, "winch wire"};
  const auto try_all = [](Bytes bytes) {
    if (const auto frame = decode_ams(bytes)) bytes = frame->data;
    (void)ReadRequest::decode(bytes);
    (void)WriteRequest::decode(bytes);
    (void)ReadWriteRequest::decode(bytes);
    (void)AddNotificationRequest::decode(bytes);
    (void)ReadResponse::decode(bytes);
    (void)SymbolEntry::decode(bytes);
    (void)PlcCommand::decode(bytes);
    (void)PlcStatus::decode(bytes);
    if (auto stream = NotificationReader::open(bytes)) {
      NotificationReader reader = *stream;
      while (reader.next()) {
      }
    }
  };
  for (int i = 0; i < 20000; ++i) {
    std::vector<std::uint8_t> bytes(random.below(160));
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random.bits());
    try_all(bytes);
    auto damaged = copy(i % 2 == 0 ? Bytes{kWriteByHandle} : Bytes{kNotification});
    damaged[random.below(static_cast<std::uint32_t>(damaged.size()))] =
        static_cast<std::uint8_t>(random.bits());
    damaged.resize(random.below(static_cast<std::uint32_t>(damaged.size())) + 1);
    try_all(damaged);
    FrameSplitter splitter;
    splitter.append(damaged);
    for (auto next = splitter.next(); next.ok() && *next; next = splitter.next()) try_all((**next).body);
  }
}

}  // namespace
}  // namespace motionlab::winch
