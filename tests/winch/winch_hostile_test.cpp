// Both ends under frames that are well-formed down to the ADS data, and mad from there on.
#include <gtest/gtest.h>

#include <array>

#include "drivers/core/random.hpp"
#include "tests/winch/winch_bench.hpp"

namespace motionlab::winch {
namespace {

/// An AMS frame with random ADS data, between two given addresses.
class Mad {
 public:
  Bytes frame(const AmsAddress& target, const AmsAddress& source, std::uint16_t flags) {
    const std::uint32_t size = random_.below(80);
    for (std::uint32_t i = 0; i < size; ++i) data_[i] = static_cast<std::uint8_t>(random_.below(256));
    LittleWriter writer{data_};
    if (random_.chance(0.8)) {  // a group that exists, then small numbers
      constexpr std::array<std::uint32_t, 19> kGroups = {
          0x4020, 0x4040, 0xF003, 0xF004, 0xF005, 0xF006, 0xF007, 0xF008, 0xF009, 0xF00B,
          0xF00C, 0xF00E, 0xF00F, 0xF011, 0xF080, 0xF082, 0xF085, 0xF086, 0xF100};
      writer.write(kGroups[random_.below(kGroups.size())]);
      writer.write(random_.below(random_.chance(0.5) ? 4 : 600));
      writer.write(random_.below(random_.chance(0.5) ? 4 : 0xFFFFFFFF));
      writer.write(random_.chance(0.7) ? size - std::min(size, 16U) : random_.below(0xFFFFFFFF));
    }
    const AmsHeader header{target, source, static_cast<std::uint16_t>(random_.below(11)),
                           flags,  0,      random_.below(2000)};
    return *encode_frame(frame_, header, Raw{Bytes{data_}.first(size)});
  }
  Random& random() { return random_; }

 private:
  struct Raw {
    Bytes data;
    void encode(LittleWriter& writer) const { writer.write_bytes(data); }
  };
  Random random_{20260311, "mad"};
  std::array<std::uint8_t, 96> data_{};
  std::array<std::uint8_t, 256> frame_{};
};

TEST(WinchHostile, TheControllerAnswersMadRequestsAndGoesOn) {
  Bench bench;
  bench.engage();
  Mad mad;
  const DriverConfig config;
  const AmsAddress stranger{{{1, 1, 1, 1, 1, 1}}, 9};
  bench.device_->on_accepted(999, {1, 1}, bench.now());
  for (int i = 0; i < 50'000; ++i) {
    const Bytes frame = mad.frame(config.target, stranger, kRequestFlags);
    constexpr std::size_t kCommandAt = kTcpHeaderSize + 16;
    if (frame[kCommandAt] == 5) continue;  // WriteControl may stop the PLC, rightly
    bench.device_->on_bytes(999, frame, bench.now());
  }
  EXPECT_EQ(bench.device_->sessions(), 2U);
  EXPECT_GT(bench.device_->malformed(), 1000U);
  EXPECT_LE(bench.device_->handles(), 4096U);
  EXPECT_LE(bench.device_->subscriptions(), 550U);
  bench.device_->on_closed(999, bench.now());
  bench.run(6s);
  EXPECT_EQ(bench.driver_->health().phase(), LinkPhase::up);
}

TEST(WinchHostile, TheDriverCountsMadFramesAndEnablesNothing) {
  Bench bench;
  bench.run(500ms);
  Mad mad;
  const DriverConfig config;
  std::uint64_t slipped_in = 0;
  for (int i = 0; i < 50'000; ++i) {
    const std::uint16_t flags = mad.random().chance(0.5) ? kRequestFlags : kResponseFlags;
    const auto before = bench.driver_->health().rejected_total();
    bench.driver_->on_bytes(mad.frame(config.local, config.target, flags), bench.now());
    slipped_in += bench.driver_->health().rejected_total() - before;
    if (i % 100 == 0) bench.run(20ms);
    ASSERT_FALSE(bench.driver_->halted()) << i;
    ASSERT_FALSE(bench.device_->plc().state() == PlcState::hold) << i;
  }
  EXPECT_GT(slipped_in, 10'000U);
  bench.run(5s);
  EXPECT_EQ(bench.driver_->health().phase(), LinkPhase::up);
  bench.engage();
  EXPECT_EQ(bench.last().drive_state, topic::WinchDriveState::hold);
}

}  // namespace
}  // namespace motionlab::winch
