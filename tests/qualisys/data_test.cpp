// Data packets. The worked example was decoded to the same values by the vendor's C++ and Python clients.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "drivers/core/random.hpp"
#include "drivers/qualisys/qualisys_wire.hpp"
#include "drivers/qualisys/qualisys_wire_data.hpp"

namespace motionlab::qualisys {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

// Constructed, checked against both vendor clients: 6DRes, "Load" at (1000.5, -250.25, 1500) mm, yaw +90 deg,
// residual 0.25 mm; a second body is lost. 5 s, frame 500, drop rate 2 per mille, out of sync 1 per mille.
ByteBuffer worked_example() {
  constexpr auto kBegin = std::to_array<std::uint8_t>(
      {0x90, 0x00, 0x00, 0x00, 0x03, 0x00, 0x00, 0x00, 0x40, 0x4b, 0x4c, 0x00, 0x00, 0x00, 0x00, 0x00,
       0xf4, 0x01, 0x00, 0x00, 0x01, 0x00, 0x00, 0x00, 0x78, 0x00, 0x00, 0x00, 0x0b, 0x00, 0x00, 0x00,
       0x02, 0x00, 0x00, 0x00, 0x02, 0x00, 0x01, 0x00, 0x00, 0x20, 0x7a, 0x44, 0x00, 0x40, 0x7a, 0xc3,
       0x00, 0x80, 0xbb, 0x44, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x80, 0x3f, 0x00, 0x00, 0x00, 0x00,
       0x00, 0x00, 0x80, 0xbf, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
       0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x80, 0x3f, 0x00, 0x00, 0x80, 0x3e});
  ByteBuffer bytes(144, 0xff);
  std::copy(kBegin.begin(), kBegin.end(), bytes.begin());
  return bytes;
}

Result<DataFrame> decode_packet(const ByteBuffer& packet) {
  return decode_data(decode_datagram(packet)->payload);
}

/// A data packet written field by field.
class PacketBuilder {
 public:
  template <class T>
  PacketBuilder& add(T value) {
    bytes_.resize(bytes_.size() + sizeof(T));
    store<std::endian::little>(MutableBytes{bytes_}.last(sizeof(T)), value);
    return *this;
  }
  PacketBuilder& head(std::uint64_t timestamp_us, std::uint32_t frame, std::uint32_t components) {
    return add(timestamp_us).add(frame).add(components);
  }
  PacketBuilder& component(std::uint32_t size, std::uint32_t type) { return add(size).add(type); }
  PacketBuilder& floats(std::initializer_list<float> values) {
    for (const float v : values) add(v);
    return *this;
  }
  [[nodiscard]] Bytes payload() const { return bytes_; }

 private:
  ByteBuffer bytes_;
};

/// A frame of one body at (1, 2, 3) m with this column-major matrix, with residual 0.5 mm.
PacketBuilder one_body(std::initializer_list<float> matrix, float x_mm = 1000.0f, float residual_mm = 0.5f) {
  PacketBuilder packet;
  packet.head(1000, 1, 1).component(16 + 52, 11).add(1u).add(std::uint16_t{0}).add(std::uint16_t{0});
  packet.floats({x_mm, 2000.0f, 3000.0f}).floats(matrix).add(residual_mm);
  return packet;
}
constexpr std::initializer_list<float> kIdentity = {1, 0, 0, 0, 1, 0, 0, 0, 1};

TEST(QualisysData, DecodesTheWorkedExample) {
  const auto frame = decode_packet(worked_example());
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->timestamp_us, 5'000'000u);
  EXPECT_EQ(frame->frame_number, 500u);
  EXPECT_TRUE(frame->has_bodies());
  EXPECT_DOUBLE_EQ(frame->drop_rate, 0.002);
  EXPECT_DOUBLE_EQ(frame->out_of_sync_rate, 0.001);
  EXPECT_FALSE(frame->timecode);
  ASSERT_EQ(frame->bodies.size, 2u);
  const BodyPose& load = frame->bodies.all[0];
  EXPECT_TRUE(load.tracked);
  EXPECT_DOUBLE_EQ(load.p_camera_body_m[0], 1.0005);
  EXPECT_DOUBLE_EQ(load.p_camera_body_m[1], -0.25025);
  EXPECT_DOUBLE_EQ(load.p_camera_body_m[2], 1.5);
  EXPECT_NEAR(load.q_camera_body[0], std::sqrt(0.5), 1e-15);
  EXPECT_NEAR(load.q_camera_body[1], 0.0, 1e-15);
  EXPECT_NEAR(load.q_camera_body[2], 0.0, 1e-15);
  EXPECT_NEAR(load.q_camera_body[3], std::sqrt(0.5), 1e-15);
  EXPECT_DOUBLE_EQ(load.residual_m, 0.00025);
  EXPECT_EQ(frame->bodies.all[1], BodyPose{}) << "a lost body has no pose at all";
}

TEST(QualisysData, EncodesTheWorkedExampleByteForByte) {
  DataFrame frame;
  frame.timestamp_us = 5'000'000;
  frame.frame_number = 500;
  frame.drop_rate = 0.002;
  frame.out_of_sync_rate = 0.001;
  frame.bodies.size = 2;
  // Sines and cosines of 45 deg do not square to exactly 1/2; a quarter turn about z from exact halves does.
  frame.bodies.all[0] = {true, {1.0005, -0.25025, 1.5}, {std::sqrt(0.5), 0.0, 0.0, std::sqrt(0.5)}, 0.00025};
  std::array<std::uint8_t, 256> buffer{};
  const auto written = encode_data(frame, {Component::bodies_res}, buffer);
  ASSERT_TRUE(written);
  const ByteBuffer expected = worked_example();
  ASSERT_EQ(written->size(), expected.size());
  const auto decoded = decode_data(written->subspan(kPacketHeaderSize));
  ASSERT_TRUE(decoded);
  // The matrix holds rounding of 1e-16 where the example has exact zeros; all other bytes are the same.
  for (std::size_t i = 0; i < expected.size(); ++i)
    if (i < 0x34 || i >= 0x58) {
      EXPECT_EQ((*written)[i], expected[i]) << "byte " << i;
    }
  for (std::size_t i = 0x34; i < 0x58; i += 4)
    EXPECT_NEAR((load<float, std::endian::little>(written->subspan(i))),
                (load<float, std::endian::little>(Bytes{expected}.subspan(i))), 1e-7);
}

TEST(QualisysData, ReadsTheMatrixColumnByColumn) {
  // Published angles convention of the camera system: roll 10, pitch 20, yaw 30 deg, R = Rx Ry Rz.
  const auto frame = decode_data(one_body({0.813798f, 0.543838f, -0.204874f, -0.469846f, 0.823173f, 0.318796f,
                                           0.342020f, -0.163176f, 0.925417f})
                                     .payload());
  ASSERT_TRUE(frame);
  constexpr double kHalf = std::numbers::pi / 360.0;
  const auto multiply = [](const std::array<double, 4>& a, const std::array<double, 4>& b) {
    return std::array<double, 4>{a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
                                 a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
                                 a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
                                 a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0]};
  };
  const std::array<double, 4> roll = {std::cos(10 * kHalf), std::sin(10 * kHalf), 0, 0};
  const std::array<double, 4> pitch = {std::cos(20 * kHalf), 0, std::sin(20 * kHalf), 0};
  const std::array<double, 4> yaw = {std::cos(30 * kHalf), 0, 0, std::sin(30 * kHalf)};
  const auto expected = multiply(multiply(roll, pitch), yaw);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(frame->bodies.all[0].q_camera_body[i], expected[i], 1e-6);
}

TEST(QualisysData, GivesHalfTurnsAboutEveryAxisAUnitQuaternion) {
  const std::initializer_list<float> turns[3] = {
      {1, 0, 0, 0, -1, 0, 0, 0, -1}, {-1, 0, 0, 0, 1, 0, 0, 0, -1}, {-1, 0, 0, 0, -1, 0, 0, 0, 1}};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto frame = decode_data(one_body(turns[axis]).payload());
    ASSERT_TRUE(frame);
    for (std::size_t i = 0; i < 4; ++i)
      EXPECT_DOUBLE_EQ(frame->bodies.all[0].q_camera_body[i], i == axis + 1 ? 1.0 : 0.0);
  }
}

TEST(QualisysData, TakesABodyWithAnyValueThatIsNotFiniteForLost) {
  for (std::size_t value = 0; value < 13; ++value) {
    for (const float bad : {kNan, -kNan, std::numeric_limits<float>::infinity()}) {
      const PacketBuilder packet = one_body(kIdentity);
      ByteBuffer bytes{packet.payload().begin(), packet.payload().end()};
      store<std::endian::little>(MutableBytes{bytes}.subspan(16 + 16 + 4 * value), bad);
      const auto frame = decode_data(bytes);
      ASSERT_TRUE(frame);
      EXPECT_EQ(frame->bodies.all[0], BodyPose{}) << "value " << value;
    }
  }
}

TEST(QualisysData, RefusesAMatrixThatIsNoRotation) {
  EXPECT_EQ(decode_data(one_body({2, 0, 0, 0, 1, 0, 0, 0, 1}).payload()).fault().reason, Reason::bad_value);
  EXPECT_EQ(decode_data(one_body({0, 0, 0, 0, 0, 0, 0, 0, 0}).payload()).fault().reason, Reason::bad_value);
  EXPECT_EQ(decode_data(one_body({-1, 0, 0, 0, 1, 0, 0, 0, 1}).payload()).fault().reason, Reason::bad_value)
      << "a mirror";
  EXPECT_EQ(decode_data(one_body({1, 0.01f, 0, 0, 1, 0, 0, 0, 1}).payload()).fault().reason,
            Reason::bad_value);
  EXPECT_TRUE(decode_data(one_body({1, 1e-4f, 0, -1e-4f, 1, 0, 0, 0, 1}).payload()));
}

TEST(QualisysData, RefusesABodyFurtherAwayThanCamerasSee) {
  EXPECT_EQ(decode_data(one_body(kIdentity, 1.1e6f).payload()).fault().reason, Reason::bad_value);
  EXPECT_TRUE(decode_data(one_body(kIdentity, 0.9e6f).payload()));
}

TEST(QualisysData, ReadsBodiesWithoutResidualAndSkipsUnknownComponents) {
  PacketBuilder packet;
  packet.head(7, 8, 2).component(12, 99).add(0xdeadbeefu);
  packet.component(16 + 48, 5).add(1u).add(std::uint16_t{0}).add(std::uint16_t{2000});
  packet.floats({1, 2, 3}).floats(kIdentity);
  const auto frame = decode_data(packet.payload());
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->bodies.size, 1u);
  EXPECT_DOUBLE_EQ(frame->bodies.all[0].p_camera_body_m[2], 0.003);
  EXPECT_EQ(frame->bodies.all[0].residual_m, 0.0);
  EXPECT_EQ(frame->out_of_sync_rate, 1.0) << "a rate above 1 is cut";
}

TEST(QualisysData, ReadsAPacketWithoutBodies) {
  const auto frame = decode_data(PacketBuilder{}.head(7, 8, 0).payload());
  ASSERT_TRUE(frame);
  EXPECT_FALSE(frame->has_bodies());
  EXPECT_EQ(frame->bodies.size, 0u);
}

Result<DataFrame> timecode(std::uint32_t kind, std::uint32_t high, std::uint32_t low) {
  return decode_data(
      PacketBuilder{}.head(0, 0, 1).component(24, 17).add(1u).add(kind).add(high).add(low).payload());
}

TEST(QualisysData, ReadsTheThreeKindsOfTimecode) {
  const std::uint32_t clock = 23u | 59u << 5 | 58u << 11;
  EXPECT_EQ(timecode(0, 0, clock | 24u << 17 | 300u << 22)->timecode,
            (Timecode{SmpteTime{23, 59, 58, 24, 300}}));
  EXPECT_EQ(timecode(1, 26u | 326u << 7, clock | 9u << 17)->timecode,
            (Timecode{IrigTime{26, 326, 23, 59, 58, 9}}));
  EXPECT_EQ(timecode(2, 1, 5)->timecode, (Timecode{CameraTime{Nanoseconds{100 * ((1LL << 32) + 5)}}}));
  EXPECT_FALSE(timecode(3, 1, 5)->timecode) << "a kind of the future is passed over";
  EXPECT_EQ(timecode(2, 0xffffffff, 0).fault().reason, Reason::bad_value);
}

TEST(QualisysData, PrefersCameraTimeToOtherTimecodes) {
  PacketBuilder packet;
  packet.head(0, 0, 1).component(36, 17).add(2u).add(0u).add(0u).add(1u).add(2u).add(0u).add(7u);
  EXPECT_EQ(decode_data(packet.payload())->timecode, (Timecode{CameraTime{Nanoseconds{700}}}));
}

TEST(QualisysData, RefusesEveryTruncationOfTheWorkedExample) {
  const ByteBuffer packet = worked_example();
  for (std::size_t size = kPacketHeaderSize; size < packet.size(); ++size)
    EXPECT_EQ(decode_data(Bytes{packet}.subspan(kPacketHeaderSize, size - kPacketHeaderSize)).fault().reason,
              Reason::too_short);
}

TEST(QualisysData, RefusesBytesBehindTheLastComponent) {
  ByteBuffer packet = worked_example();
  packet.push_back(0);
  EXPECT_EQ(decode_data(Bytes{packet}.subspan(kPacketHeaderSize)).fault().reason, Reason::too_long);
}

TEST(QualisysData, RefusesSizesAndCountsThatContradictEachOther) {
  ByteBuffer more_bodies = worked_example();
  more_bodies[0x20] = 3;
  EXPECT_EQ(decode_packet(more_bodies).fault().reason, Reason::bad_header);
  ByteBuffer too_many = worked_example();
  too_many[0x20] = 65;
  EXPECT_EQ(decode_packet(too_many).fault().reason, Reason::too_long);
  ByteBuffer huge = worked_example();
  std::fill_n(huge.begin() + 0x20, 4, std::uint8_t{0xff});
  EXPECT_EQ(decode_packet(huge).fault().reason, Reason::too_long);
  ByteBuffer tiny_component = worked_example();
  tiny_component[0x18] = 7;
  EXPECT_EQ(decode_packet(tiny_component).fault().reason, Reason::bad_header);
  ByteBuffer long_component = worked_example();
  long_component[0x18] = 0x79;
  EXPECT_EQ(decode_packet(long_component).fault().reason, Reason::too_short);
  ByteBuffer more_components = worked_example();
  more_components[0x14] = 2;
  EXPECT_EQ(decode_packet(more_components).fault().reason, Reason::too_short);
  EXPECT_EQ(decode_data(PacketBuilder{}.head(0, 0, 1).component(8, 11).payload()).fault().reason,
            Reason::too_short);
  EXPECT_EQ(decode_data(PacketBuilder{}.head(0, 0, 1).component(8, 17).payload()).fault().reason,
            Reason::too_short);
  EXPECT_EQ(decode_data(PacketBuilder{}.head(0, 0, 1).component(12, 17).add(1u).payload()).fault().reason,
            Reason::bad_header);
  EXPECT_EQ(
      decode_data(PacketBuilder{}.head(0, 0, 1).component(13, 17).add(0u).add(std::uint8_t{0}).payload())
          .fault()
          .reason,
      Reason::bad_header);
}

TEST(QualisysData, RefusesAComponentThatComesTwice) {
  PacketBuilder packet;
  packet.head(0, 0, 2).component(12, 17).add(0u).component(12, 17).add(0u);
  EXPECT_EQ(decode_data(packet.payload()).fault().reason, Reason::bad_header);
}

TEST(QualisysData, RefusesATimeStampThatWouldOverflow) {
  EXPECT_EQ(decode_data(PacketBuilder{}.head(~std::uint64_t{0}, 0, 0).payload()).fault().reason,
            Reason::bad_value);
}

TEST(QualisysData, EncodesOnlyWhatWasAskedFor) {
  DataFrame frame;
  frame.bodies.size = 1;
  frame.timecode = CameraTime{Nanoseconds{700}};
  std::array<std::uint8_t, 256> buffer{};
  EXPECT_EQ(encode_data(frame, {}, buffer)->size(), 24u);
  EXPECT_EQ(encode_data(frame, {Component::bodies}, buffer)->size(), 24u + 16 + 48);
  EXPECT_EQ(encode_data(frame, {Component::bodies_res}, buffer)->size(), 24u + 16 + 52);
  EXPECT_EQ(encode_data(frame, {Component::timecode}, buffer)->size(), 24u + 24);
  EXPECT_EQ(encode_data(frame, {Component::bodies, Component::bodies_res}, MutableBytes{buffer}.first(100))
                .fault()
                .reason,
            Reason::too_long);
  frame.timecode.reset();
  EXPECT_EQ(encode_data(frame, {Component::timecode}, buffer)->size(), 24u) << "no time code, no component";
}

TEST(QualisysData, KeepsTheResidualWhenBothKindsOfBodiesCome) {
  DataFrame frame;
  frame.bodies.size = 1;
  frame.bodies.all[0] = {true, {1, 2, 3}, {1, 0, 0, 0}, 0.5};
  std::array<std::uint8_t, 256> buffer{};
  const auto both = encode_data(frame, {Component::bodies, Component::bodies_res}, buffer);
  EXPECT_DOUBLE_EQ(decode_data(both->subspan(kPacketHeaderSize))->bodies.all[0].residual_m, 0.5);
}

TEST(QualisysData, KeepsPosesThroughEncodingAndDecoding) {
  Random random{11};
  for (int round = 0; round < 500; ++round) {
    DataFrame frame;
    frame.timestamp_us = random.bits() >> 12;
    frame.frame_number = random.below(1u << 31);
    frame.bodies.size = random.below(kMaxBodies + 1);
    frame.timecode = IrigTime{26, 326, 1, 2, 3, 4};
    for (std::size_t i = 0; i < frame.bodies.size; ++i) {
      if (random.chance(0.3)) continue;
      BodyPose& pose = frame.bodies.all[i];
      pose.tracked = true;
      double norm = 0.0;
      for (double& q : pose.q_camera_body) q = random.normal();
      for (const double q : pose.q_camera_body) norm += q * q;
      for (double& q : pose.q_camera_body) q /= std::sqrt(norm);
      for (double& p : pose.p_camera_body_m) p = random.uniform(-9.0, 9.0);
      pose.residual_m = random.uniform();
    }
    std::array<std::uint8_t, 8192> buffer{};
    const auto bytes = encode_data(frame, {Component::bodies_res, Component::timecode}, buffer);
    ASSERT_TRUE(bytes);
    const auto back = decode_data(decode_datagram(*bytes)->payload);
    ASSERT_TRUE(back);
    EXPECT_EQ(back->timestamp_us, frame.timestamp_us);
    EXPECT_EQ(back->frame_number, frame.frame_number);
    EXPECT_EQ(back->timecode, frame.timecode);
    ASSERT_EQ(back->bodies.size, frame.bodies.size);
    for (std::size_t i = 0; i < frame.bodies.size; ++i) {
      const BodyPose& a = frame.bodies.all[i];
      const BodyPose& b = back->bodies.all[i];
      ASSERT_EQ(a.tracked, b.tracked);
      double dot = 0.0;
      for (std::size_t k = 0; k < 4; ++k) dot += a.q_camera_body[k] * b.q_camera_body[k];
      if (a.tracked) {
        EXPECT_NEAR(std::abs(dot), 1.0, 1e-6);
      }
      for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(a.p_camera_body_m[k], b.p_camera_body_m[k], 1e-6);
    }
  }
}

TEST(QualisysData, SurvivesRandomChangesOfTheWorkedExample) {
  Random random{13};
  const ByteBuffer original = worked_example();
  for (int round = 0; round < 50'000; ++round) {
    ByteBuffer bytes = original;
    for (std::uint32_t change = 0, changes = 1 + random.below(6); change < changes; ++change)
      bytes[random.below(static_cast<std::uint32_t>(bytes.size()))] =
          static_cast<std::uint8_t>(random.bits());
    bytes.resize(bytes.size() - random.below(3));
    const auto frame = decode_data(Bytes{bytes}.subspan(kPacketHeaderSize));
    if (!frame) continue;
    for (const BodyPose& pose : frame->bodies.view()) {
      double norm = 0.0;
      for (const double q : pose.q_camera_body) norm += q * q;
      EXPECT_NEAR(norm, pose.tracked ? 1.0 : 0.0, 1e-12);
    }
  }
}

}  // namespace
}  // namespace motionlab::qualisys
