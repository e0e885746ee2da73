/// Driver and simulated unit joined in memory over every fault that a unit can have: what the driver says of
/// it (health, quality, advice), what still comes through, and that all is well again afterwards.
#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include "drivers/core/random.hpp"
#include "tests/mru/mru_pair.hpp"

namespace motionlab::mru {
namespace {

constexpr std::array kEveryFault{
    "off",     "stuck", "garbage",     "wrong",       "slow",    "delayed",  "silent",       "unstable",
    "reduced", "nan",   "freeze_time", "wrong_token", "restart", "oversize", "bad_checksum", "intermittent"};

/// What has to be true of one second with the fault.
struct Cell {
  Format format = Format::mrubin;
  std::string fault;
  double value = 0.0;
  std::size_t samples_min = 0, samples_max = 0;  ///< of 200 without a fault
  std::optional<bool> stable{};                  ///< of the newest sample
  bool suspect = false;                          ///< the newest sample is
  LinkPhase phase = LinkPhase::up;               ///< at the end of the second
  std::optional<Reason> reason{};                ///< for which at least one in ten was refused
  std::uint64_t lost_min = 0, lost_max = 0;      ///< counted when the fault is over
  std::uint64_t reconnects = 0;                  ///< counted when the fault is over
  std::string advice{};                          ///< is in what the driver advises
  ChecksumPolicy policy = ChecksumPolicy::count;
};
void PrintTo(const Cell& cell, std::ostream* out) {
  *out << to_string(cell.format) << " " << cell.fault;
}

class MruFaultMatrix : public ::testing::TestWithParam<Cell> {
 protected:
  static DeviceConfig device(const Cell& cell) {
    DeviceConfig config;
    config.format = cell.format;
    return config;
  }
  static DriverConfig driver(const Cell& cell) {
    DriverConfig config;
    config.format = cell.format;
    config.stuck_after_s = 0.025;
    config.checksum = {.policy = cell.policy, .rule = {}, .frames_to_score = 100};
    return config;
  }
};

TEST_P(MruFaultMatrix, IsSaidAnsweredAndRecoveredFrom) {
  const Cell& cell = GetParam();
  MruPair pair{device(cell), driver(cell)};
  const LinkHealth& health = pair.driver.health();
  pair.run(2s);
  ASSERT_EQ(health.phase(), LinkPhase::up);
  ASSERT_EQ(health.rejected_total(), 0u);
  ASSERT_TRUE(health.advice().empty()) << health.advice();
  ASSERT_TRUE(pair.samples.back().stable);
  const auto lost = health.lost();

  // What left before the fault may still be under way.
  ASSERT_TRUE(pair.device.set_fault(cell.fault, true, cell.value).ok());
  pair.run(10ms);
  pair.samples.clear();
  pair.run(1s);
  EXPECT_GE(pair.samples.size(), cell.samples_min);
  EXPECT_LE(pair.samples.size(), cell.samples_max);
  EXPECT_EQ(health.phase(), cell.phase);
  EXPECT_NE(health.advice().find(cell.advice), std::string_view::npos) << health.advice();
  EXPECT_EQ(health.advice().empty(), cell.advice.empty()) << health.advice();
  if (cell.reason) {
    EXPECT_GE(health.rejected(*cell.reason), 20u);
  } else {
    EXPECT_EQ(health.rejected_total(), 0u);
  }
  if (cell.stable) {
    ASSERT_FALSE(pair.samples.empty());
    EXPECT_EQ(pair.samples.back().stable, *cell.stable);
    EXPECT_EQ(pair.samples.back().checksum_suspect, cell.suspect);
  }
  for (const topic::Mru& sample : pair.samples) {
    EXPECT_LE(std::abs(sample.euler_heading_mru_rad[0]), std::numbers::pi / 2)
        << "nothing wild comes through";
    EXPECT_LE(sample.t_measured_ns, sample.t_received_ns);
  }

  ASSERT_TRUE(pair.device.set_fault(cell.fault, false).ok());
  pair.run(200ms);
  pair.samples.clear();
  const auto rejected = health.rejected_total();
  const auto reconnects = health.reconnects();
  pair.run(1s);
  EXPECT_EQ(pair.samples.size(), 200u);
  EXPECT_EQ(health.phase(), LinkPhase::up);
  EXPECT_TRUE(health.advice().empty()) << health.advice();
  EXPECT_TRUE(pair.samples.back().stable);
  EXPECT_FALSE(pair.samples.back().checksum_suspect);
  EXPECT_EQ(health.rejected_total(), rejected) << "it goes on refusing";
  EXPECT_EQ(reconnects, cell.reconnects);
  EXPECT_GE(health.lost() - lost, cell.lost_min);
  EXPECT_LE(health.lost() - lost, cell.lost_max);
  // The clock is right again: 5 ms are the latency; text has no time at all.
  const double age_s =
      1e-9 * static_cast<double>(pair.samples.back().t_received_ns - pair.samples.back().t_measured_ns);
  EXPECT_NEAR(age_s, 0.005, 1.1e-3);
}

std::vector<Cell> cells() {
  using enum Format;
  std::vector<Cell> all;
  for (const Format format : kFormats) {
    const bool has_time = has_list(format) || format == km_binary || format == bin23;
    const bool noisy = format == mrubin || format == km_binary;
    const auto lost = [&](std::uint64_t n) { return has_time ? n : 0; };
    // The unit boots: SystemTime begins anew, UTC does not.
    all.push_back({.format = format,
                   .fault = "off",
                   .phase = LinkPhase::down,
                   .lost_min = has_list(format) ? 0 : lost(195),
                   .lost_max = has_list(format) ? 0 : lost(210),
                   .reconnects = has_list(format) ? 1u : 0u,
                   .advice = "fallen silent"});
    all.push_back({.format = format,
                   .fault = "silent",
                   .phase = LinkPhase::down,
                   .lost_min = lost(195),
                   .lost_max = lost(210),
                   .advice = "fallen silent"});
    // Formats of coarse whole numbers stand still on a ship at rest too: nothing is said of them.
    all.push_back({.format = format,
                   .fault = "stuck",
                   .samples_min = 200,
                   .samples_max = 200,
                   .stable = !noisy,
                   .advice = noisy ? "to the last bit" : ""});
    // Only a second sensor could know.
    all.push_back({.format = format,
                   .fault = "wrong",
                   .value = 0.1,
                   .samples_min = 200,
                   .samples_max = 200,
                   .stable = true});
    all.push_back({.format = format,
                   .fault = "slow",
                   .value = 4,
                   .samples_min = 50,
                   .samples_max = 51,
                   .stable = true,
                   .lost_min = lost(140),
                   .lost_max = lost(160)});
    all.push_back({.format = format,
                   .fault = "delayed",
                   .value = 0.05,
                   .samples_min = 190,
                   .samples_max = 200,
                   .stable = true});
    all.push_back({.format = format,
                   .fault = "intermittent",
                   .value = 0.05,
                   .samples_min = 80,
                   .samples_max = 120,
                   .stable = true,
                   .lost_min = lost(80),
                   .lost_max = lost(120)});
    all.push_back({.format = format,
                   .fault = "oversize",
                   .value = 7,
                   .phase = LinkPhase::down,
                   .reason = format == psxn || format == prdid ? Reason::bad_header
                             : format == nmeap                 ? Reason::too_short
                                                               : Reason::too_long,
                   .lost_min = lost(195),
                   .lost_max = lost(210),
                   .advice = "No good datagram"});
    all.push_back({.format = format,
                   .fault = "nan",
                   .phase = LinkPhase::down,
                   .reason = Reason::bad_value,
                   .lost_min = lost(195),
                   .lost_max = lost(210),
                   .advice = "No good datagram"});
    // Of EM1000 and EM3000 one byte is the whole mark: in 200 random datagrams it may come up.
    const bool weak = format == em1000 || format == em3000;
    if (!weak) {
      all.push_back({.format = format,
                     .fault = "garbage",
                     .phase = LinkPhase::down,
                     .reason = Reason::bad_header,
                     .lost_min = lost(195),
                     .lost_max = lost(210),
                     .advice = "No good datagram"});
    }
    if (format != em1000 && format != prdid) {
      all.push_back({.format = format,
                     .fault = "unstable",
                     .samples_min = 200,
                     .samples_max = 200,
                     .stable = false,
                     .advice = "settling"});
    }
    if (format == km_binary || format == bin23 || format == em3000 || format == psxn) {
      all.push_back({.format = format,
                     .fault = "reduced",
                     .samples_min = 200,
                     .samples_max = 200,
                     .stable = true,
                     .advice = "reduced performance"});
    }
    if (has_time) {
      all.push_back({.format = format,
                     .fault = "freeze_time",
                     .samples_max = 0,
                     .phase = LinkPhase::down,
                     .reason = Reason::duplicate,
                     .lost_min = 195,
                     .lost_max = 210,
                     .advice = "No good datagram"});
    }
    all.push_back({.format = format,
                   .fault = "restart",
                   .samples_min = 195,
                   .samples_max = 205,
                   .stable = true,
                   .reconnects = has_list(format) ? 1u : 0u});
    if (has_list(format) || format == bin23 || format == psxn || format == prdid) {
      all.push_back({.format = format,
                     .fault = "bad_checksum",
                     .samples_min = 200,
                     .samples_max = 200,
                     .stable = true,
                     .suspect = true});
      all.push_back({.format = format,
                     .fault = "bad_checksum",
                     .phase = LinkPhase::down,
                     .reason = Reason::bad_checksum,
                     .lost_min = lost(195),
                     .lost_max = lost(210),
                     .advice = "No good datagram",
                     .policy = ChecksumPolicy::enforce});
      all.push_back({.format = format,
                     .fault = "bad_checksum",
                     .samples_min = 200,
                     .samples_max = 200,
                     .stable = true,
                     .policy = ChecksumPolicy::ignore});
    }
    if (has_list(format)) {
      all.push_back({.format = format,
                     .fault = "wrong_token",
                     .phase = LinkPhase::down,
                     .reason = Reason::bad_header,
                     .lost_min = 195,
                     .lost_max = 210,
                     .advice = "No good datagram"});
    }
  }
  return all;
}

INSTANTIATE_TEST_SUITE_P(All, MruFaultMatrix, ::testing::ValuesIn(cells()), [](const auto& test) {
  return std::string{to_string(test.param.format)} + "_" + test.param.fault + "_" +
         std::to_string(test.index);
});

TEST(MruFaults, AreAllInTheMatrix) {
  MruPair pair;
  const std::string_view names = pair.device.set_fault("?", true).fault().text;
  const std::vector<Cell> all = cells();
  for (const std::string fault : kEveryFault) {
    EXPECT_NE(names.find(fault), std::string_view::npos) << fault;
    EXPECT_TRUE(std::ranges::any_of(all, [&](const Cell& cell) { return cell.fault == fault; })) << fault;
  }
  const std::string_view list = names.substr(names.find(':') + 2);
  EXPECT_EQ(static_cast<std::size_t>(std::ranges::count(list, ' ')) + 1, kEveryFault.size());
}

TEST(MruFaults, EveryPairOfThemEndsWell) {
  for (const Format format : kFormats) {
    for (const std::string first : kEveryFault) {
      for (const std::string second : kEveryFault) {
        MruPair pair = MruPair::speaking(format);
        // Longer than the greatest step back of its time that passes for a late datagram.
        pair.run(1500ms);
        // Some the format cannot have.
        (void)pair.device.set_fault(first, true);
        pair.run(30ms);
        (void)pair.device.set_fault(second, true);
        pair.run(30ms);
        ASSERT_TRUE(pair.device.set_fault(first, false).ok());
        ASSERT_TRUE(pair.device.set_fault(second, false).ok());
        pair.run(100ms);
        pair.samples.clear();
        pair.run(100ms);
        EXPECT_EQ(pair.samples.size(), 20u) << to_string(format) << " " << first << " " << second;
        EXPECT_EQ(pair.driver.health().phase(), LinkPhase::up);
        EXPECT_TRUE(pair.samples.empty() || pair.samples.back().stable);
      }
    }
  }
}

TEST(MruFaults, GarbageOfAWeaklyMarkedFormatIsRefusedOrPlausible) {
  for (const Format format : {Format::em3000, Format::em1000}) {
    MruPair pair = MruPair::speaking(format);
    ASSERT_TRUE(pair.device.set_fault("garbage", true).ok());
    pair.run(100s);
    EXPECT_GT(pair.driver.health().rejected(Reason::bad_header), 19'000u);
    EXPECT_LT(pair.samples.size(), 20u) << "one byte in 256, a status in 8, a plausible tilt in 4 twice";
  }
}

}  // namespace
}  // namespace motionlab::mru
