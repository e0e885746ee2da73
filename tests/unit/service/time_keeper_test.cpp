#include "gateway/service/time_keeper.hpp"

#include <gtest/gtest.h>

#include <string>

namespace motionlab::service {
namespace {

GatewayConfig configuration() {
  const std::string folder = std::string(MOTIONLAB_SOURCE_DIR) + "/deploy/config/";
  return load_gateway_config(folder + "lab.toml", {folder + "loopback.toml"});
}

constexpr LabTime at(Nanoseconds t) {
  return LabTime{t};
}

TEST(TimeHistogram, EveryTimeFallsBetweenTheEdgesOfItsBucket) {
  for (double us = 0.01; us < 1e6; us *= 1.05) {
    const std::size_t bucket = TimeHistogram::bucket(us);
    if (bucket + 1 < TimeHistogram::kBuckets) {
      EXPECT_LT(us, TimeHistogram::upper_us(bucket) * (1 + 1e-12)) << us;
    }
    if (bucket > 0) {
      EXPECT_GE(us, TimeHistogram::upper_us(bucket - 1) * (1 - 1e-12)) << us;
    }
  }
  EXPECT_EQ(TimeHistogram::bucket(-1.0), 0U);
  EXPECT_EQ(TimeHistogram::bucket(std::nan("")), 0U);
}

TEST(TimeHistogram, QuantilesAreInterpolatedInTheirBucket) {
  TimeHistogram histogram;
  for (int i = 1; i <= 1000; ++i) histogram.add(i);
  EXPECT_NEAR(TimeHistogram::quantile_us(histogram.counts(), 0.5), 500, 0.03 * 500);
  EXPECT_NEAR(TimeHistogram::quantile_us(histogram.counts(), 0.99), 990, 0.03 * 990);
  EXPECT_NEAR(TimeHistogram::quantile_us(histogram.counts(), 0.0), 1, 1e-9);
  EXPECT_NEAR(TimeHistogram::quantile_us(histogram.counts(), 1.0), 1024, 1e-9) << "the end of its bucket";
  EXPECT_EQ(histogram.max_us(), 1000);
  EXPECT_EQ(TimeHistogram::quantile_us({}, 0.5), 0.0);
}

/// A keeper that is told of steps, with an MRU sample every 5 ms that can be late.
struct Bench {
  GatewayConfig config = configuration();
  TimeKeeper dut{config};
  Snapshot now;
  std::uint64_t sequence = 0;

  void sample(Nanoseconds measured, Nanoseconds received) {
    now.mru.emplace();
    now.mru->sequence_number = ++sequence;
    now.mru->t_measured_ns = measured.count();
    now.mru->t_received_ns = received.count();
  }
  void step(Nanoseconds t, double us = 10) {
    now.t = at(t);
    dut.stepped(now, us, std::nullopt);
  }
  std::array<std::uint64_t, 4> missed() const { return dut.health(now.t).missed_deadlines; }
};

TEST(TimeKeeper, AttributesEachMissedDeadline) {
  Bench b;
  for (int i = 0; i < 100; ++i) {
    if (i % 5 == 0) b.sample(1ms * i, 1ms * i);
    b.step(1ms * i);
  }
  EXPECT_EQ(b.missed(), (std::array<std::uint64_t, 4>{0, 0, 0, 0}));

  b.dut.woke(2500us, 2);
  EXPECT_EQ(b.missed(), (std::array<std::uint64_t, 4>{2, 0, 0, 0}));
  b.step(103ms, 1500);
  EXPECT_EQ(b.missed(), (std::array<std::uint64_t, 4>{2, 1, 0, 0}));

  // Measured in time, but 25 ms under way.
  b.sample(100ms, 125ms);
  b.step(125ms);
  EXPECT_EQ(b.missed(), (std::array<std::uint64_t, 4>{2, 1, 1, 0}));
  EXPECT_NE(b.dut.timing(b.now.t).last_missed.view().find("mru1"), std::string_view::npos);
  EXPECT_NE(b.dut.timing(b.now.t).last_missed.view().find("in time"), std::string_view::npos);

  // Not measured for 40 ms.
  b.sample(140ms, 165ms);
  b.step(165ms);
  EXPECT_EQ(b.missed(), (std::array<std::uint64_t, 4>{2, 1, 1, 1}));
  EXPECT_NE(b.dut.timing(b.now.t).last_missed.view().find("lost"), std::string_view::npos);
  b.step(166ms);
  EXPECT_EQ(b.missed(), (std::array<std::uint64_t, 4>{2, 1, 1, 1})) << "once each";
}

TEST(TimeKeeper, CountsPageFaultsAfterItsFirstSecondOnly) {
  Bench b;
  b.dut.page_faults(500);
  for (int i = 0; i < 1000; ++i) b.step(1ms * i);
  b.dut.page_faults(700);
  EXPECT_EQ(b.dut.timing(b.now.t).page_faults, 0U);
  b.dut.page_faults(703);
  EXPECT_EQ(b.dut.timing(b.now.t).page_faults, 3U);
}

}  // namespace
}  // namespace motionlab::service
