#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <type_traits>
#include <vector>

#include "gateway/bus/type_support.hpp"
#include "tests/unit/bus/samples.hpp"

namespace motionlab::bus {
namespace {

namespace fastrtps = eprosima::fastrtps;
using Payload = fastrtps::rtps::SerializedPayload_t;

/// The way back, for comparison only: the house never reads through a twin.
struct CopyFromTwin {
  template <class Plain, class Twin>
  void operator()(Plain& plain, const Twin& twin) const {
    plain = static_cast<Plain>(twin);
  }
  template <std::size_t N>
  void operator()(Text<N>& plain, const fastrtps::fixed_string<N>& twin) const {
    plain.assign(twin.c_str());
  }
  template <class Plain, class Twin, std::size_t N>
  void operator()(std::array<Plain, N>& plain, const std::array<Twin, N>& twin) const {
    for (std::size_t i = 0; i < N; ++i) (*this)(plain[i], twin[i]);
  }
};

template <class T>
std::vector<char> bytes_of(const T& sample) {
  TypeSupport<T> support;
  Payload payload{support.m_typeSize};
  Carried<T> carried{sample, {}};
  EXPECT_TRUE(support.serialize(&carried, &payload));
  return {payload.data, payload.data + payload.length};
}

template <class T>
class EveryType : public testing::Test {};
TYPED_TEST_SUITE(EveryType, AllTopics::Types::Into<testing::Types>);

TYPED_TEST(EveryType, ComesBackFromItsTwinUnchanged) {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    const auto sample = random_sample<TypeParam>(seed);
    typename TwinOf<TypeParam>::Twin twin;
    to_twin(sample, twin);
    TypeParam back;
    TypeParam::zip(back, twin, CopyFromTwin{});
    EXPECT_EQ(differences(sample, back), std::vector<std::string>{});
  }
}

TYPED_TEST(EveryType, ComesBackFromItsBytesUnchanged) {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    const auto sample = random_sample<TypeParam>(seed);
    auto bytes = bytes_of(sample);
    TypeParam back;
    EXPECT_EQ(read_cdr(bytes.data(), bytes.size(), back), Refusal::none);
    EXPECT_EQ(differences(sample, back), std::vector<std::string>{});
  }
}

TYPED_TEST(EveryType, IsReadAlikeByTheGeneratedReader) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const auto sample = random_sample<TypeParam>(seed);
    const auto bytes = bytes_of(sample);
    Payload payload{static_cast<std::uint32_t>(bytes.size())};
    std::memcpy(payload.data, bytes.data(), bytes.size());
    payload.length = static_cast<std::uint32_t>(bytes.size());
    typename TwinOf<TypeParam>::Support generated;
    typename TwinOf<TypeParam>::Twin twin;
    ASSERT_TRUE(generated.deserialize(&payload, &twin));
    TypeParam back;
    TypeParam::zip(back, twin, CopyFromTwin{});
    EXPECT_EQ(differences(sample, back), std::vector<std::string>{});
  }
}

TYPED_TEST(EveryType, FitsIntoTheSizeThatTheTypeAnnounces) {
  auto sample = random_sample<TypeParam>(1);
  TypeParam::fields(sample, [](std::string_view, auto& field) {
    if constexpr (requires { field.view(); }) field.assign(std::string(1000, 'x'));
  });
  EXPECT_LE(bytes_of(sample).size(), TypeSupport<TypeParam>{}.m_typeSize);
}

TYPED_TEST(EveryType, IsRefusedWhenCutAnywhere) {
  const auto whole = bytes_of(random_sample<TypeParam>(3));
  for (std::size_t size = 0; size < whole.size(); ++size) {
    auto cut = std::vector<char>(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
    TypeParam back;
    EXPECT_EQ(read_cdr(cut.data(), cut.size(), back), Refusal::malformed) << size;
  }
}

TYPED_TEST(EveryType, SurvivesRandomBytes) {
  Dice dice{42};
  const auto whole = bytes_of(random_sample<TypeParam>(5));
  TypeSupport<TypeParam> support;
  for (int round = 0; round < 2000; ++round) {
    auto bytes = whole;
    if (round % 2 == 0) {
      for (char& byte : bytes) byte = static_cast<char>(dice.next());
      if (bytes.size() > 4 && round % 4 == 0) std::memcpy(bytes.data(), whole.data(), 4);
    } else {
      bytes[dice.below(bytes.size())] = static_cast<char>(dice.next());
    }
    bytes.resize(dice.below(bytes.size() + 1));
    Payload payload{static_cast<std::uint32_t>(bytes.size() + 1)};
    std::memcpy(payload.data, bytes.data(), bytes.size());
    payload.length = static_cast<std::uint32_t>(bytes.size());
    Carried<TypeParam> carried;
    EXPECT_TRUE(support.deserialize(&payload, &carried));
    fastrtps::rtps::InstanceHandle_t handle;
    EXPECT_EQ(support.getKey(&carried, &handle), TypeParam::kKeyed);
  }
}

TYPED_TEST(EveryType, IsRefusedWithAnInfinityOrANanWhereNoneMayBe) {
  std::vector<std::string_view> names;
  const TypeParam empty{};
  TypeParam::fields(empty, [&](std::string_view name, const auto& field) {
    using Field = std::remove_cvref_t<decltype(field)>;
    if constexpr (std::is_same_v<Field, double>) names.push_back(name);
    if constexpr (requires { requires std::is_same_v<typename Field::value_type, double>; })
      names.push_back(name);
  });
  for (const std::string_view name : names) {
    for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity()}) {
      auto sample = random_sample<TypeParam>(7);
      TypeParam::fields(sample, [&](std::string_view field_name, auto& field) {
        using Field = std::remove_cvref_t<decltype(field)>;
        if (field_name != name) return;
        if constexpr (std::is_same_v<Field, double>) field = bad;
        if constexpr (requires { requires std::is_same_v<typename Field::value_type, double>; })
          field.back() = bad;
      });
      const bool allowed = std::isnan(bad) && std::ranges::find(TopicTraits<TypeParam>::may_be_nan, name) !=
                                                  TopicTraits<TypeParam>::may_be_nan.end();
      auto bytes = bytes_of(sample);
      TypeParam back;
      EXPECT_EQ(read_cdr(bytes.data(), bytes.size(), back), allowed ? Refusal::none : Refusal::not_finite)
          << name;
    }
  }
}

/// Bytes by hand, as another implementation may write them.
class Cdr {
 public:
  explicit Cdr(std::endian order) : order_{order} {
    bytes_ = {0, order == std::endian::little ? char{1} : char{0}, 0, 0};
  }
  template <class Number>
  Cdr& number(Number value) {
    while ((bytes_.size() - 4) % sizeof value != 0) bytes_.push_back(0);
    std::array<char, sizeof value> raw;
    std::memcpy(raw.data(), &value, sizeof value);
    if (order_ != std::endian::native) std::reverse(raw.begin(), raw.end());
    bytes_.insert(bytes_.end(), raw.begin(), raw.end());
    return *this;
  }
  Cdr& text(const std::string& text) {
    number(static_cast<std::uint32_t>(text.size() + 1));
    bytes_.insert(bytes_.end(), text.begin(), text.end());
    bytes_.push_back('\0');
    return *this;
  }
  std::vector<char>& bytes() { return bytes_; }

 private:
  std::endian order_;
  std::vector<char> bytes_;
};

Cdr request(std::endian order, const std::string& requester, std::uint32_t action) {
  return Cdr{order}
      .text(requester)
      .number(std::uint64_t{17})
      .number(std::int64_t{-5})
      .number(action)
      .number(std::uint8_t{1})
      .number(std::uint32_t{2});
}

TEST(ReadCdr, UnderstandsBothByteOrders) {
  for (const std::endian order : {std::endian::little, std::endian::big}) {
    auto bytes = request(order, "console", 1).bytes();
    topic::ModeRequest sample;
    ASSERT_EQ(read_cdr(bytes.data(), bytes.size(), sample), Refusal::none);
    EXPECT_EQ(sample.requester.view(), "console");
    EXPECT_EQ(sample.sequence_number, 17u);
    EXPECT_EQ(sample.t_created_ns, -5);
    EXPECT_EQ(sample.action, topic::ModeAction::engage);
    EXPECT_EQ(sample.authority, topic::Authority::limited);
  }
}

TEST(ReadCdr, TakesATextOfExactlyItsBoundAndRefusesOneMore) {
  topic::ModeRequest sample;
  auto full = request(std::endian::little, std::string(32, 'r'), 0).bytes();
  EXPECT_EQ(read_cdr(full.data(), full.size(), sample), Refusal::none);
  EXPECT_EQ(sample.requester.view(), std::string(32, 'r'));
  for (const std::size_t size : {33u, 34u, 300u, 4000u}) {
    auto longer = request(std::endian::little, std::string(size, 'r'), 0).bytes();
    EXPECT_EQ(read_cdr(longer.data(), longer.size(), sample), Refusal::text_too_long) << size;
  }
}

TEST(ReadCdr, RefusesAnUnknownEnumerator) {
  topic::ModeRequest sample;
  for (const std::uint32_t action : {4u, 1000u, 0xffffffffu}) {
    auto bytes = request(std::endian::little, "r", action).bytes();
    EXPECT_EQ(read_cdr(bytes.data(), bytes.size(), sample), Refusal::unknown_enum);
  }
}

TEST(ReadCdr, RefusesABooleanOfTwo) {
  topic::SimControl sample;
  for (const std::uint8_t boolean : std::vector<std::uint8_t>{0, 1, 2, 255}) {
    auto bytes = Cdr{std::endian::little}
                     .text("mru1")
                     .number(std::uint64_t{1})
                     .text("silent")
                     .number(boolean)
                     .number(0.5)
                     .bytes();
    EXPECT_EQ(read_cdr(bytes.data(), bytes.size(), sample), boolean < 2 ? Refusal::none : Refusal::malformed);
  }
}

TEST(ReadCdr, RefusesATextWithoutItsEndAndALengthBeyondThePayload) {
  topic::ModeRequest sample;
  auto bytes = request(std::endian::little, "abc", 0).bytes();
  bytes[4 + 4 + 3] = 'd';  // the terminator
  EXPECT_EQ(read_cdr(bytes.data(), bytes.size(), sample), Refusal::malformed);
  bytes = request(std::endian::little, "abc", 0).bytes();
  for (std::size_t i = 4; i < 8; ++i) bytes[i] = static_cast<char>(0xff);
  EXPECT_EQ(read_cdr(bytes.data(), bytes.size(), sample), Refusal::malformed);
}

TEST(ReadCdr, RefusesAnUnknownEncapsulation) {
  topic::ModeRequest sample;
  auto bytes = request(std::endian::little, "abc", 0).bytes();
  bytes[1] = 0x7f;
  EXPECT_EQ(read_cdr(bytes.data(), bytes.size(), sample), Refusal::malformed);
}

}  // namespace
}  // namespace motionlab::bus
