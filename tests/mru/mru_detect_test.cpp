#include "drivers/mru/mru_wire_detect.hpp"

#include <gtest/gtest.h>

#include "drivers/core/random.hpp"
#include "tests/mru/mru_golden.hpp"

namespace motionlab::mru {
namespace {

TEST(MruDetect, KnowsEveryGoldenDatagram) {
  for (const Golden& golden : all_golden()) EXPECT_EQ(looks_like(golden.bytes), golden.format);
  EXPECT_EQ(looks_like(kPublished), Format::mrubin);
}

TEST(MruDetect, KnowsNoPrefixOfAGoldenDatagram) {
  for (const Golden& golden : all_golden()) {
    for (std::size_t n = 0; n < golden.bytes.size(); ++n) {
      EXPECT_FALSE(looks_like(Bytes{golden.bytes}.first(n))) << to_string(golden.format) << " " << n;
    }
  }
}

TEST(MruDetect, NeedsThreeDatagramsOfAStrongFormatAndTwentyOfAWeakOne) {
  for (const Golden& golden : all_golden()) {
    const bool weak = golden.format == Format::em3000 || golden.format == Format::em1000;
    const std::uint64_t needed = weak ? 20 : 3;
    FormatDetector dut;
    for (std::uint64_t i = 1; i <= needed; ++i) {
      EXPECT_FALSE(dut.format()) << i;
      dut.take(golden.bytes);
    }
    EXPECT_EQ(dut.format(), golden.format);
    EXPECT_EQ(dut.datagrams(), needed);
    EXPECT_EQ(dut.size(), golden.bytes.size());
  }
}

TEST(MruDetect, TellsTokenAndNumberOfVariablesWhereTheUserChoseThem) {
  FormatDetector dut;
  EXPECT_FALSE(dut.token());
  dut.take(kPublished);
  EXPECT_EQ(dut.token(), 0x2F);
  EXPECT_EQ(dut.variables(), 4u);
  dut.take(kLaboratoryFrame);
  EXPECT_EQ(dut.token(), 11);
  EXPECT_EQ(dut.variables(), 24u);
  dut.take(as_bytes(kNmeap));
  EXPECT_EQ(dut.token(), 11);
  EXPECT_EQ(dut.variables(), 3u);
}

TEST(MruDetect, DoesNotDecideOnAMixture) {
  FormatDetector dut;
  for (int i = 0; i < 100; ++i) {
    dut.take(kKmFrame);
    dut.take(kBin23Frame);
  }
  EXPECT_FALSE(dut.format());
}

TEST(MruDetect, FindsNothingInNoise) {
  Random random{9};
  FormatDetector dut;
  for (int i = 0; i < 20000; ++i) {
    ByteBuffer noise(random.below(140));
    for (auto& byte : noise) byte = static_cast<std::uint8_t>(random.bits());
    dut.take(noise);
  }
  EXPECT_FALSE(dut.format());
}

}  // namespace
}  // namespace motionlab::mru
