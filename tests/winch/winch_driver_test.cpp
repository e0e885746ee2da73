// What the driver does with frames that a well-behaved controller never sends: they are slipped into a
// healthy connection.
#include <gtest/gtest.h>

#include <array>
#include <limits>
#include <string_view>
#include <utility>
#include <vector>

#include "tests/winch/winch_bench.hpp"

namespace motionlab::winch {
namespace {

// Numbers that a fresh simulated controller gives to its first client.
constexpr std::uint32_t kCommandHandle = 1;
constexpr std::uint32_t kVersionNotification = 1;
constexpr std::uint32_t kStatusNotification = 2;

class Tampered : public Bench {
 public:
  Tampered() { run(500ms); }

  template <class Message>
  void slip_in(AmsHeader header, const Message& message) {
    std::array<std::uint8_t, 1024> buffer{};
    const auto frame = encode_frame(buffer, header, message);
    ASSERT_TRUE(frame.ok());
    driver_->on_bytes(*frame, now());
  }

  void slip_in_sample(std::uint32_t handle, Bytes data) {
    const NotificationSample sample{handle, data};
    const NotificationStamp stamp{to_filetime(now().time_since_epoch()), {&sample, 1}};
    slip_in(from_plc(AdsCommand::notification, kRequestFlags), NotificationStream{{&stamp, 1}});
  }

  [[nodiscard]] AmsHeader from_plc(AdsCommand ads, std::uint16_t flags = kResponseFlags) const {
    return {config.local, config.target, static_cast<std::uint16_t>(ads), flags, 0, 0xFFFFFF};
  }

  [[nodiscard]] std::uint64_t rejected(Reason reason) const { return driver_->health().rejected(reason); }
  [[nodiscard]] bool up() const { return driver_->health().phase() == LinkPhase::up; }

  DriverConfig config{};
};

TEST(WinchDriver, CountsFramesThatAreNotForUs) {
  Tampered bench;
  auto header = bench.from_plc(AdsCommand::write);
  header.source.net_id = NetId{{9, 9, 9, 9, 1, 1}};
  bench.slip_in(header, ResultResponse{0});
  header = bench.from_plc(AdsCommand::write);
  header.target.port = 1;
  bench.slip_in(header, ResultResponse{0});
  EXPECT_EQ(bench.rejected(Reason::foreign), 2U);
  bench.run(100ms);
  EXPECT_TRUE(bench.up());
}

TEST(WinchDriver, CountsAnswersNobodyAskedForAndRequestsThatBounced) {
  Tampered bench;
  bench.slip_in(bench.from_plc(AdsCommand::write), ResultResponse{0});
  EXPECT_EQ(bench.rejected(Reason::unexpected), 1U);
  bench.slip_in(AmsHeader{bench.config.target, bench.config.local, 3, kRequestFlags, 0, 1},
                ResultResponse{0});
  EXPECT_EQ(bench.rejected(Reason::unexpected), 2U);
  EXPECT_NE(bench.driver_->health().last_fault()->text.find("route"), std::string_view::npos);
  std::array<std::uint8_t, 16> buffer{};
  const std::array<std::uint8_t, 2> port = {1, 0};
  bench.driver_->on_bytes(*encode_tcp_frame(buffer, TcpCommand::router_note, port), bench.now());
  EXPECT_EQ(bench.rejected(Reason::unexpected), 3U);
  EXPECT_TRUE(bench.up());
}

TEST(WinchDriver, RefusesSamplesOfAnotherSizeAndStreamsThatDoNotAddUp) {
  Tampered bench;
  const auto told = bench.states_.size();
  bench.slip_in_sample(kStatusNotification, std::array<std::uint8_t, 119>{});
  bench.slip_in_sample(kVersionNotification, std::array<std::uint8_t, 2>{});
  EXPECT_EQ(bench.rejected(Reason::bad_header), 2U);
  bench.slip_in(bench.from_plc(AdsCommand::notification, kRequestFlags), ResultResponse{0});
  EXPECT_EQ(bench.rejected(Reason::too_short), 1U);
  EXPECT_EQ(bench.states_.size(), told);
  EXPECT_TRUE(bench.up());
}

TEST(WinchDriver, RefusesAStatusThatIsNotFiniteAndGoesOn) {
  Tampered bench;
  const auto told = bench.states_.size();
  std::array<std::uint8_t, kStatusSize> bytes{};
  LittleWriter writer{bytes};
  PlcStatus status;
  status.cycle_count = 5000;
  status.position_m = std::numeric_limits<double>::quiet_NaN();
  status.encode(writer);
  bench.slip_in_sample(kStatusNotification, bytes);
  EXPECT_EQ(bench.rejected(Reason::bad_value), 1U);
  EXPECT_EQ(bench.states_.size(), told);
  bench.run(100ms);
  EXPECT_TRUE(bench.up());
}

TEST(WinchDriver, HaltsWhenTheLayoutVersionChangesUnderWay) {
  Tampered bench;
  bench.slip_in_sample(kStatusNotification, std::array<std::uint8_t, kStatusSize>{2});
  EXPECT_TRUE(bench.driver_->halted());
  bench.run(3s);
  EXPECT_TRUE(bench.driver_->halted());
  EXPECT_EQ(bench.device_->sessions(), 0U);
}

TEST(WinchDriver, ResolvesAgainOnceWithoutReconnectingAndStaysEnabled) {
  for (const int kind : {0, 1, 2}) {
    Tampered bench;
    bench.engage();
    if (kind == 0) bench.slip_in_sample(kStatusNotification, {});
    if (kind == 1) bench.slip_in_sample(kVersionNotification, std::array<std::uint8_t, 1>{77});
    if (kind == 2) {  // the controller forgets our handle: its answer to the next write is error 0x703
      std::array<std::uint8_t, 4> handle{};
      store<std::endian::little>(handle, kCommandHandle);
      std::array<std::uint8_t, 128> buffer{};
      const AmsHeader header{bench.config.target, {{{1, 1, 1, 1, 1, 1}}, 9}, 3, kRequestFlags, 0, 1};
      bench.device_->on_accepted(999, {1, 1}, bench.now());
      bench.device_->on_bytes(999, *encode_frame(buffer, header, WriteRequest{0xF006, 0, handle}),
                              bench.now());
    }
    bench.run(500ms);
    EXPECT_EQ(bench.driver_->counters().resolved_again, 1U) << kind;
    EXPECT_EQ(bench.driver_->health().reconnects(), 0U) << kind;
    EXPECT_TRUE(bench.up()) << kind;
    EXPECT_EQ(bench.last().drive_state, topic::WinchDriveState::hold) << kind;
    EXPECT_EQ(bench.device_->subscriptions(), 2U) << kind;
  }
}

TEST(WinchDriver, ReconnectsWhenResolvingAgainDidNotHelp) {
  Tampered bench;
  bench.slip_in_sample(kStatusNotification, {});
  bench.run(100ms);
  bench.slip_in_sample(kStatusNotification + 2, {});  // the new subscription
  EXPECT_FALSE(bench.up());
  bench.run(3s);
  EXPECT_TRUE(bench.up());
  EXPECT_EQ(bench.driver_->health().reconnects(), 1U);
}

TEST(WinchDriver, ReconnectsOnAMalformedFrame) {
  const std::vector<std::pair<std::vector<std::uint8_t>, Reason>> kinds = {
      {{0, 0, 31, 0, 0, 0}, Reason::too_short},
      {{0, 0, 1, 0, 1, 0}, Reason::too_long},  // 64 KiB + 1
      {{'G', 'E', 'T', ' ', '/', ' '}, Reason::bad_header},
  };
  for (const auto& [bytes, reason] : kinds) {
    Tampered bench;
    bench.driver_->on_bytes(bytes, bench.now());
    EXPECT_EQ(bench.rejected(reason), 1U);
    EXPECT_FALSE(bench.up());
    EXPECT_NE(bench.driver_->health().advice().find("malformed"), std::string_view::npos);
    bench.run(2s);
    EXPECT_TRUE(bench.up());
  }
}

}  // namespace
}  // namespace motionlab::winch
