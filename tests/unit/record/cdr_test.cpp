// Samples as bytes: the same as the bus's own encoding, and back to the bit.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <optional>

#include "gateway/bus/type_support.hpp"
#include "gateway/record/cdr.hpp"
#include "gateway/record/field_text.hpp"
#include "gateway/record/run_tape.hpp"
#include "idl/schemas.hpp"
#include "tests/unit/record/filled.hpp"

namespace motionlab::record {
namespace {

template <class T>
ByteBuffer bytes_of(const T& sample) {
  ByteBuffer buffer(RunTape::kLargestStep);
  buffer.resize(write_cdr(sample, buffer));
  EXPECT_FALSE(buffer.empty());
  return buffer;
}

/// Where two encodings begin to differ: at the field in which their samples do.
std::size_t first_difference(const ByteBuffer& left, const ByteBuffer& right) {
  return static_cast<std::size_t>(std::ranges::mismatch(left, right).in1 - left.begin());
}

std::optional<Reason> refusal(const Status& status) {
  return status ? std::nullopt : std::optional(status.fault().reason);
}

template <class T>
class EveryTopic : public testing::Test {};
#define MOTIONLAB_TYPE(Type) , topic::Type
template <class First, class... T>
using Tail = testing::Types<T...>;
using TopicTypes = Tail<void MOTIONLAB_FOR_EACH_TOPIC_TYPE(MOTIONLAB_TYPE)>;
#undef MOTIONLAB_TYPE
TYPED_TEST_SUITE(EveryTopic, TopicTypes);

TYPED_TEST(EveryTopic, HasTheBytesThatFastDdsWrites) {
  const bus::Carried<TypeParam> carried{filled<TypeParam>(7), {}};
  bus::TypeSupport<TypeParam> support;
  eprosima::fastrtps::rtps::SerializedPayload_t payload(64 * 1024);
  ASSERT_TRUE(support.serialize(const_cast<bus::Carried<TypeParam>*>(&carried), &payload));
  const ByteBuffer ours = bytes_of(carried.sample);
  ASSERT_EQ(ours.size(), payload.length);
  EXPECT_TRUE(std::equal(ours.begin(), ours.end(), payload.data));
}

TYPED_TEST(EveryTopic, ComesBackToTheBit) {
  const auto sample = filled<TypeParam>(3);
  const ByteBuffer bytes = bytes_of(sample);
  TypeParam again{};
  ASSERT_TRUE(read_cdr(bytes, again));
  EXPECT_EQ(field_texts(sample), field_texts(again));
  EXPECT_EQ(bytes_of(again), bytes);
}

TYPED_TEST(EveryTopic, IsRefusedWhenItIsShorterOrLonger) {
  const ByteBuffer bytes = bytes_of(filled<TypeParam>(3));
  TypeParam again{};
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_FALSE(read_cdr(Bytes{bytes}.first(size), again)) << size;
  }
  ByteBuffer longer = bytes;
  longer.push_back(0);
  EXPECT_EQ(read_cdr(longer, again).fault().reason, Reason::too_long);
  ByteBuffer small(bytes.size() - 1);
  EXPECT_EQ(write_cdr(filled<TypeParam>(3), small), 0U);
}

TYPED_TEST(EveryTopic, HasItsSchemaWithoutIncludes) {
  EXPECT_NE(topic::kSchema<TypeParam>.find("struct"), std::string_view::npos);
  EXPECT_EQ(topic::kSchema<TypeParam>.find("#include"), std::string_view::npos);
}

TEST(Cdr, ASnapshotThatIsFullComesBackAndFitsOnTheTape) {
  topic::Snapshot full;
  full.sequence_number = 1;
  full.mru.push(filled<topic::Mru>(1));
  full.load.push(filled<topic::Bodies>(2));
  full.platform.push(filled<topic::Bodies>(3));
  full.arm.push(filled<topic::ArmState>(4));
  full.winch.push(filled<topic::WinchState>(5));
  full.second_mru.push(filled<topic::Mru>(6));
  while (full.requests.push(filled<topic::ModeRequest>(full.requests.size()))) continue;
  while (full.references.push(filled<topic::Reference>(full.references.size()))) continue;
  while (full.sent.push(filled<topic::ArmCommand>(full.sent.size()))) continue;
  const ByteBuffer bytes = bytes_of(full);
  topic::Snapshot again;
  ASSERT_TRUE(read_cdr(bytes, again));
  EXPECT_EQ(field_texts(full), field_texts(again));

  RunTape tape;
  tape.begin(full);
  tape.add(filled<topic::Estimate>(1));
  tape.add(filled<topic::Control>(1));
  tape.add(filled<topic::ArmCommand>(1));
  tape.add(filled<topic::WinchCommand>(1));
  tape.add(filled<topic::Mode>(1));
  tape.add(filled<topic::Event>(1));
  tape.end();
  EXPECT_EQ(tape.lost(), 0U);
}

TEST(Cdr, NumbersThatAreNoneComeBackWithTheirBits) {
  topic::Mru sample;
  sample.a_mru_mps2 = {std::bit_cast<double>(0x7ff8dead'beef0001ULL),
                       -std::numeric_limits<double>::infinity(), -0.0};
  topic::Mru again;
  ASSERT_TRUE(read_cdr(bytes_of(sample), again));
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(std::bit_cast<std::uint64_t>(again.a_mru_mps2[i]),
              std::bit_cast<std::uint64_t>(sample.a_mru_mps2[i]));
  }
  EXPECT_NE(field_texts(sample), field_texts(topic::Mru{}));
}

TEST(Cdr, ValuesThatATypeCannotHaveAreRefused) {
  topic::ModeRequest request;
  request.action = static_cast<topic::ModeAction>(99);
  topic::ModeRequest again;
  EXPECT_EQ(refusal(read_cdr(bytes_of(request), again)), Reason::bad_value);
  EXPECT_EQ(again.action, topic::ModeAction{});

  topic::ArmCommand command;
  ByteBuffer bytes = bytes_of(command);
  command.follow = !command.follow;
  bytes[first_difference(bytes, bytes_of(command))] = 2;
  topic::ArmCommand other;
  EXPECT_EQ(refusal(read_cdr(bytes, other)), Reason::bad_value);

  topic::Snapshot snapshot;
  bytes = bytes_of(snapshot);
  topic::Snapshot one_sample;
  one_sample.mru.push({});
  bytes[first_difference(bytes, bytes_of(one_sample))] = 2;  // in a sequence of at most one
  EXPECT_EQ(refusal(read_cdr(bytes, snapshot)), Reason::bad_value);
}

}  // namespace
}  // namespace motionlab::record
