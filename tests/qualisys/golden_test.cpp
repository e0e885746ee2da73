// Packets whose bytes are written out here. "Published" follows the vendor's documentation, "constructed" was
// put together from its tables of offsets; none was made by our encoder.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "drivers/qualisys/qualisys_wire.hpp"
#include "drivers/qualisys/qualisys_wire_data.hpp"
#include "drivers/qualisys/qualisys_wire_discovery.hpp"

namespace motionlab::qualisys {
namespace {

ByteBuffer from_hex(std::string_view hex) {
  ByteBuffer bytes;
  std::string digits;
  for (const char c : hex) {
    if (c == ' ') continue;
    digits += c;
    if (digits.size() < 2) continue;
    bytes.push_back(static_cast<std::uint8_t>(std::stoi(digits, nullptr, 16)));
    digits.clear();
  }
  return bytes;
}

/// One component alone: the same item in both byte orders, at the place and with the size of the
/// documentation's table.
struct Golden {
  const char* word;
  Component component;
  const char* little;  ///< behind the frame's header: component header, head of the items, items
  const char* big;
};

// Constructed. Head of each: 1 item, drop rate 2 and out of sync 1 per mille. The item: position
// (1000.5, -250.25, 1500) mm = 447a2000 c37a4000 44bb8000; matrix of a quarter turn about z, by columns
// (0 1 0, -1 0 0, 0 0 1); angles (10, 20, 30) deg = 41200000 41a00000 41f00000; number 7; residual 0.25 mm
// = 3e800000.
constexpr std::array kGolden = {
    Golden{"3D", Component::markers, "1c000000 01000000 01000000 0200 0100 00207a44 00407ac3 0080bb44",
           "0000001c 00000001 00000001 0002 0001 447a2000 c37a4000 44bb8000"},
    Golden{"3DNoLabels", Component::unlabelled,
           "20000000 02000000 01000000 0200 0100 00207a44 00407ac3 0080bb44 07000000",
           "00000020 00000002 00000001 0002 0001 447a2000 c37a4000 44bb8000 00000007"},
    Golden{
        "6D", Component::bodies,
        "40000000 05000000 01000000 0200 0100 00207a44 00407ac3 0080bb44 00000000 0000803f 00000000 000080bf "
        "00000000 00000000 00000000 00000000 0000803f",
        "00000040 00000005 00000001 0002 0001 447a2000 c37a4000 44bb8000 00000000 3f800000 00000000 bf800000 "
        "00000000 00000000 00000000 00000000 3f800000"},
    Golden{"6DEuler", Component::angles,
           "28000000 06000000 01000000 0200 0100 00207a44 00407ac3 0080bb44 00002041 0000a041 0000f041",
           "00000028 00000006 00000001 0002 0001 447a2000 c37a4000 44bb8000 41200000 41a00000 41f00000"},
    Golden{"3DRes", Component::markers_res,
           "20000000 09000000 01000000 0200 0100 00207a44 00407ac3 0080bb44 0000803e",
           "00000020 00000009 00000001 0002 0001 447a2000 c37a4000 44bb8000 3e800000"},
    Golden{"3DNoLabelsRes", Component::unlabelled_res,
           "24000000 0a000000 01000000 0200 0100 00207a44 00407ac3 0080bb44 07000000 0000803e",
           "00000024 0000000a 00000001 0002 0001 447a2000 c37a4000 44bb8000 00000007 3e800000"},
    Golden{
        "6DRes", Component::bodies_res,
        "44000000 0b000000 01000000 0200 0100 00207a44 00407ac3 0080bb44 00000000 0000803f 00000000 000080bf "
        "00000000 00000000 00000000 00000000 0000803f 0000803e",
        "00000044 0000000b 00000001 0002 0001 447a2000 c37a4000 44bb8000 00000000 3f800000 00000000 bf800000 "
        "00000000 00000000 00000000 00000000 3f800000 3e800000"},
    Golden{
        "6DEulerRes", Component::angles_res,
        "2c000000 0c000000 01000000 0200 0100 00207a44 00407ac3 0080bb44 00002041 0000a041 0000f041 0000803e",
        "0000002c 0000000c 00000001 0002 0001 447a2000 c37a4000 44bb8000 41200000 41a00000 41f00000 "
        "3e800000"},
    Golden{"Timecode", Component::timecode, "18000000 11000000 01000000 02000000 01000000 05000000",
           "00000018 00000011 00000001 00000002 00000001 00000005"},
};

// Published, the frame header of the documentation's order of fields: 5 s, frame 500, one component.
constexpr const char* kLittleHead = "404b4c0000000000 f4010000 01000000";
constexpr const char* kBigHead = "00000000004c4b40 000001f4 00000001";

ByteBuffer packet_of(const Golden& golden, std::endian order) {
  const bool little = order == std::endian::little;
  const ByteBuffer payload =
      from_hex(std::string(little ? kLittleHead : kBigHead) + (little ? golden.little : golden.big));
  ByteBuffer packet = from_hex(little ? "00000000 03000000" : "00000000 00000003");
  packet.insert(packet.end(), payload.begin(), payload.end());
  packet[little ? 0 : 3] = static_cast<std::uint8_t>(packet.size());
  return packet;
}

class QualisysGolden : public testing::TestWithParam<std::tuple<Golden, std::endian>> {
 protected:
  [[nodiscard]] static const Golden& golden() { return std::get<0>(GetParam()); }
  [[nodiscard]] static std::endian order() { return std::get<1>(GetParam()); }
  const ByteBuffer packet = packet_of(golden(), order());
};

TEST_P(QualisysGolden, IsReadInSi) {
  const auto outer = decode_datagram(packet, order());
  ASSERT_TRUE(outer);
  const auto frame = decode_data(outer->payload, order());
  ASSERT_TRUE(frame) << frame.fault().text;
  EXPECT_EQ(frame->timestamp_us, 5'000'000u);
  EXPECT_EQ(frame->frame_number, 500u);
  EXPECT_EQ(frame->present, Components{golden().component});
  const std::string word = golden().word;
  if (word == "Timecode") {
    EXPECT_EQ(frame->timecode, (Timecode{CameraTime{Nanoseconds{100 * ((1LL << 32) + 5)}}}));
    return;
  }
  EXPECT_DOUBLE_EQ(frame->drop_rate, 0.002);
  EXPECT_DOUBLE_EQ(frame->out_of_sync_rate, 0.001);
  const std::array<double, 3> p_m{1.0005, -0.25025, 1.5};
  const double residual_m = word.ends_with("Res") ? 0.00025 : 0.0;
  const auto expect_place = [&](const std::array<double, 3>& p, double residual) {
    for (std::size_t i = 0; i < 3; ++i) EXPECT_DOUBLE_EQ(p[i], p_m[i]);
    EXPECT_DOUBLE_EQ(residual, residual_m);
  };
  if (word.starts_with("3DNoLabels")) {
    ASSERT_EQ(frame->unlabelled.size, 1u);
    expect_place(frame->unlabelled.all[0].p_camera_marker_m, frame->unlabelled.all[0].residual_m);
    EXPECT_EQ(frame->unlabelled.all[0].id, 7u);
  } else if (word.starts_with("3D")) {
    ASSERT_EQ(frame->markers.size, 1u);
    expect_place(frame->markers.all[0].p_camera_marker_m, frame->markers.all[0].residual_m);
  } else if (word.starts_with("6DEuler")) {
    ASSERT_EQ(frame->angles.size, 1u);
    expect_place(frame->angles.all[0].p_camera_body_m, frame->angles.all[0].residual_m);
    for (std::size_t i = 0; i < 3; ++i)
      EXPECT_DOUBLE_EQ(frame->angles.all[0].angles_rad[i],
                       static_cast<double>(10 * (i + 1)) * std::numbers::pi / 180.0);
  } else {
    ASSERT_EQ(frame->bodies.size, 1u);
    expect_place(frame->bodies.all[0].p_camera_body_m, frame->bodies.all[0].residual_m);
    EXPECT_NEAR(frame->bodies.all[0].q_camera_body[0], std::sqrt(0.5), 1e-15);
    EXPECT_NEAR(frame->bodies.all[0].q_camera_body[3], std::sqrt(0.5), 1e-15);
  }
}

TEST_P(QualisysGolden, IsWrittenAgainByteForByte) {
  const auto frame = decode_data(decode_datagram(packet, order())->payload, order());
  ASSERT_TRUE(frame);
  std::array<std::uint8_t, 256> buffer{};
  const auto written = encode_data(*frame, {golden().component}, buffer, order());
  ASSERT_TRUE(written);
  ASSERT_EQ(written->size(), packet.size());
  const bool matrix = std::string_view{golden().word}.starts_with("6D") && frame->has_bodies();
  for (std::size_t i = 0; i < packet.size(); ++i) {
    // Sines and cosines of 45 deg do not square to exactly 1/2: the matrix is compared as numbers.
    if (matrix && i >= 0x34 && i < 0x58) continue;
    EXPECT_EQ((*written)[i], packet[i]) << "byte " << i;
  }
  const auto again = decode_data(decode_datagram(*written, order())->payload, order());
  ASSERT_TRUE(again);
  for (std::size_t i = 0; i < frame->bodies.size; ++i)
    for (std::size_t k = 0; k < 4; ++k)
      EXPECT_NEAR(again->bodies.all[i].q_camera_body[k], frame->bodies.all[i].q_camera_body[k], 1e-7);
}

TEST_P(QualisysGolden, HasNoPrefixThatIsTaken) {
  for (std::size_t size = 0; size < packet.size(); ++size)
    EXPECT_EQ(decode_datagram(Bytes{packet}.first(size), order()).fault().reason, Reason::too_short);
  const Bytes payload = Bytes{packet}.subspan(kPacketHeaderSize);
  for (std::size_t size = 0; size < payload.size(); ++size)
    EXPECT_EQ(decode_data(payload.first(size), order()).fault().reason, Reason::too_short);
}

TEST_P(QualisysGolden, IsRefusedInTheOtherByteOrder) {
  const std::endian other = order() == std::endian::little ? std::endian::big : std::endian::little;
  EXPECT_FALSE(decode_datagram(packet, other));
  EXPECT_FALSE(decode_data(Bytes{packet}.subspan(kPacketHeaderSize), other));
}

INSTANTIATE_TEST_SUITE_P(Component, QualisysGolden,
                         testing::Combine(testing::ValuesIn(kGolden),
                                          testing::Values(std::endian::little, std::endian::big)),
                         [](const auto& test) {
                           return std::string{std::get<0>(test.param).word} +
                                  (std::get<1>(test.param) == std::endian::little ? "_little" : "_big");
                         });

TEST(QualisysLost, IsWrittenWithAllBitsSetAndReadAsNotTracked) {
  DataFrame frame;
  frame.bodies.size = frame.angles.size = frame.markers.size = 1;
  std::array<std::uint8_t, 256> buffer{};
  for (const auto& [component, size] :
       {std::pair{Component::bodies_res, 52}, std::pair{Component::angles_res, 28},
        std::pair{Component::markers_res, 16}, std::pair{Component::markers, 12}}) {
    const auto packet = encode_data(frame, {component}, buffer);
    ASSERT_TRUE(packet);
    ASSERT_EQ(packet->size(), 24u + 16 + static_cast<std::size_t>(size));
    EXPECT_TRUE(std::all_of(packet->begin() + 40, packet->end(), [](std::uint8_t b) { return b == 0xff; }));
    const auto back = decode_data(packet->subspan(kPacketHeaderSize));
    ASSERT_TRUE(back);
    EXPECT_FALSE(back->bodies.all[0].tracked || back->angles.all[0].tracked || back->markers.all[0].tracked);
  }
}

TEST(QualisysUnlabelled, LeavesOutAMarkerThatIsNotFiniteAndKeepsTheOthers) {
  DataFrame frame;
  frame.unlabelled.size = 2;
  frame.unlabelled.all[0] = {{std::numeric_limits<double>::quiet_NaN(), 0, 0}, 1, 0.0};
  frame.unlabelled.all[1] = {{1, 2, 3}, 2, 0.0};
  std::array<std::uint8_t, 256> buffer{};
  const auto packet = encode_data(frame, {Component::unlabelled}, buffer);
  const auto back = decode_data(packet->subspan(kPacketHeaderSize));
  ASSERT_TRUE(back);
  ASSERT_EQ(back->unlabelled.size, 1u);
  EXPECT_EQ(back->unlabelled.all[0].id, 2u);
}

// Published: the question of a client that listens on 45454.
const ByteBuffer kPublishedDiscovery = from_hex("0a000000 07000000 b18e");

TEST(QualisysDiscovery, ReadsAndWritesThePublishedQuestion) {
  EXPECT_EQ(decode_discovery(kPublishedDiscovery).value(), 45454);
  EXPECT_EQ(encode_discovery(45454), kPublishedDiscovery);
}

TEST(QualisysDiscovery, ReadsAndWritesAnAnswerWithItsTotalLengthAndTheBasePort) {
  // Constructed from the documentation's table and what the vendor's clients check: size is that of the
  // datagram.
  ByteBuffer answer = from_hex("1c000000 01000000");
  for (const char c : std::string_view{"lab, QTM 2.17, 17"}) answer.push_back(static_cast<std::uint8_t>(c));
  for (const int b : {0x00, 0x56, 0xce}) answer.push_back(static_cast<std::uint8_t>(b));
  answer[0] = static_cast<std::uint8_t>(answer.size());
  const auto read = decode_discovery_answer(answer);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->info, "lab, QTM 2.17, 17");
  EXPECT_EQ(read->base_port, 22222);
  EXPECT_EQ(encode_discovery_answer({"lab, QTM 2.17, 17", 22222}), answer);
  for (std::size_t size = 0; size < answer.size(); ++size)
    EXPECT_FALSE(decode_discovery_answer(Bytes{answer}.first(size)));
}

TEST(QualisysDiscovery, RefusesWhatIsNoQuestion) {
  for (std::size_t size = 0; size < kPublishedDiscovery.size(); ++size)
    EXPECT_EQ(decode_discovery(Bytes{kPublishedDiscovery}.first(size)).fault().reason, Reason::too_short);
  EXPECT_EQ(decode_discovery(from_hex("0b000000 07000000 b18e00")).fault().reason, Reason::too_long);
  EXPECT_EQ(decode_discovery(from_hex("0a000000 06000000 b18e")).fault().reason, Reason::bad_header);
  EXPECT_EQ(decode_discovery(from_hex("0a000000 07000000 0000")).fault().reason, Reason::bad_value);
}

}  // namespace
}  // namespace motionlab::qualisys
