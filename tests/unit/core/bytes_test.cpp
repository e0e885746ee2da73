#include "drivers/core/bytes.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>

namespace motionlab {
namespace {

constexpr std::array<std::uint8_t, 8> kCount{1, 2, 3, 4, 5, 6, 7, 8};

TEST(Bytes, LoadsEitherByteOrder) {
  EXPECT_EQ((load<std::uint16_t, std::endian::little>(kCount)), 0x0201);
  EXPECT_EQ((load<std::uint16_t, std::endian::big>(kCount)), 0x0102);
  EXPECT_EQ((load<std::uint32_t, std::endian::little>(kCount)), 0x04030201u);
  EXPECT_EQ((load<std::uint64_t, std::endian::big>(kCount)), 0x0102030405060708u);
}

TEST(Bytes, LoadsSignedAndFloatingPointValues) {
  const std::array<std::uint8_t, 2> minus_two{0xfe, 0xff};
  EXPECT_EQ((load<std::int16_t, std::endian::little>(minus_two)), -2);
  const std::array<std::uint8_t, 4> one_and_a_half{0x3f, 0xc0, 0, 0};
  EXPECT_EQ((load<float, std::endian::big>(one_and_a_half)), 1.5f);
  const std::array<std::uint8_t, 8> minus_two_double{0, 0, 0, 0, 0, 0, 0, 0xc0};
  EXPECT_EQ((load<double, std::endian::little>(minus_two_double)), -2.0);
}

TEST(Bytes, ReadsAtOddAddresses) {
  const Bytes odd = Bytes{kCount}.subspan(1);
  EXPECT_EQ((load<std::uint32_t, std::endian::big>(odd)), 0x02030405u);
}

template <class T>
void expect_round_trip(T value) {
  std::array<std::uint8_t, 16> buffer{};
  LittleWriter little(buffer);
  little.write(value);
  BigWriter big(MutableBytes{buffer}.subspan(8));
  big.write(value);
  EXPECT_EQ(little.position(), sizeof(T));
  EXPECT_EQ(LittleReader(buffer).read<T>(), value);
  EXPECT_EQ(BigReader(Bytes{buffer}.subspan(8)).read<T>(), value);
}

TEST(Bytes, WhatIsWrittenIsRead) {
  expect_round_trip<std::uint8_t>(0x80);
  expect_round_trip<std::int8_t>(-128);
  expect_round_trip<std::uint16_t>(0xfedc);
  expect_round_trip<std::int32_t>(std::numeric_limits<std::int32_t>::min());
  expect_round_trip<std::uint64_t>(0xfedcba9876543210);
  expect_round_trip<float>(-1.25f);
  expect_round_trip<double>(std::numeric_limits<double>::denorm_min());
  expect_round_trip<bool>(true);
}

TEST(Reader, WalksOverALayout) {
  BigReader reader(kCount);
  EXPECT_EQ(reader.read<std::uint8_t>(), 1);
  reader.skip(1);
  EXPECT_EQ(reader.read<std::uint16_t>(), 0x0304);
  const Bytes rest = reader.take(4);
  ASSERT_EQ(rest.size(), 4u);
  EXPECT_EQ(rest[0], 5);
  EXPECT_EQ(reader.position(), 8u);
  EXPECT_EQ(reader.remaining(), 0u);
  EXPECT_TRUE(reader.ok());
}

TEST(Reader, ReadingBeyondTheEndYieldsZeroForGood) {
  LittleReader reader(Bytes{kCount}.first(3));
  EXPECT_EQ(reader.read<std::uint32_t>(), 0u);
  EXPECT_FALSE(reader.ok());
  EXPECT_EQ(reader.read<std::uint8_t>(), 0) << "what follows a hole means nothing";
  EXPECT_EQ(reader.remaining(), 0u);
  EXPECT_TRUE(reader.take(1).empty());
  EXPECT_FALSE(reader.ok());
}

TEST(Reader, TakingNothingFromNothingIsFine) {
  LittleReader reader(Bytes{});
  EXPECT_TRUE(reader.take(0).empty());
  EXPECT_TRUE(reader.ok());
}

TEST(Reader, AnAbsurdLengthIsRefused) {
  LittleReader reader(kCount);
  reader.skip(2);
  EXPECT_TRUE(reader.take(std::numeric_limits<std::size_t>::max()).empty());
  EXPECT_FALSE(reader.ok());
}

TEST(Writer, AWriteBeyondTheEndIsDroppedWhole) {
  std::array<std::uint8_t, 3> buffer{9, 9, 9};
  LittleWriter writer(buffer);
  writer.write(std::uint16_t{0x0201});
  EXPECT_TRUE(writer.ok());
  writer.write(std::uint16_t{0x0403});
  EXPECT_FALSE(writer.ok());
  EXPECT_EQ(buffer[2], 9);
  EXPECT_EQ(writer.written().size(), 2u);
}

TEST(Writer, WritesTextAndRefusesTooMuchOfIt) {
  std::array<std::uint8_t, 4> buffer{};
  BigWriter writer(buffer);
  writer.write_bytes(as_bytes("abc"));
  writer.write_bytes({});
  EXPECT_TRUE(writer.ok());
  EXPECT_EQ(as_text(writer.written()), "abc");
  writer.write_bytes(as_bytes("de"));
  EXPECT_FALSE(writer.ok());
  EXPECT_EQ(buffer[3], 0);
}

}  // namespace
}  // namespace motionlab
