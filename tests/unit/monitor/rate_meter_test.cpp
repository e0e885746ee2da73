#include "gateway/monitor/rate_meter.hpp"

#include <gtest/gtest.h>

#include "idl/estimate.hpp"
#include "idl/mode.hpp"
#include "idl/mru.hpp"

namespace motionlab::monitor {
namespace {

template <class T>
HeardSample heard(const T& sample, std::uint64_t written, std::uint8_t writer = 1) {
  HeardSample heard;
  heard.values = values_of(sample);
  heard.instance = instance_of(sample);
  heard.writer.bytes[0] = writer;
  heard.writer_sequence = written;
  return heard;
}

topic::Mru mru(std::uint64_t number, std::int64_t t_measured_us, const char* device = "mru1") {
  topic::Mru sample;
  sample.device = device;
  sample.sequence_number = number;
  sample.t_measured_ns = 1'000 * t_measured_us;
  return sample;
}

TEST(RateMeter, TakesTheRateFromNumbersAndStampsAndNotFromArrivals) {
  RateMeter meter{*topic_named("motionlab/mru")};
  for (std::uint64_t i = 1; i <= 101; ++i) {
    HeardSample sample = heard(mru(i, 5'000 * static_cast<std::int64_t>(i)), i);
    sample.t_written_ns = sample.t_heard_ns = static_cast<std::int64_t>(i * i);  // nonsense
    meter.take(sample);
  }
  const RateReport report = meter.report();
  EXPECT_EQ(meter.stamp(), "t_measured_ns");
  ASSERT_EQ(report.instances.size(), 1u);
  EXPECT_EQ(report.instances[0].instance, "mru1");
  EXPECT_DOUBLE_EQ(report.instances[0].on_bus_hz.value(), 200);
  EXPECT_DOUBLE_EQ(report.instances[0].made_hz.value(), 200);
  EXPECT_DOUBLE_EQ(report.instances[0].period_ms.value(), 5);
  EXPECT_EQ(report.instances[0].jitter_us.max, 0);
  EXPECT_DOUBLE_EQ(report.instances[0].span_s, 0.5);
  EXPECT_EQ(report.heard, 101u);
  EXPECT_EQ(report.lost_on_dds, 0u);
}

TEST(RateMeter, CountsWhatIsMissingOfEachDevice) {
  RateMeter meter{*topic_named("motionlab/mru")};
  std::uint64_t written = 0;
  for (std::uint64_t i = 1; i <= 50; ++i) {
    ++written;
    if (i != 20 && i != 21) meter.take(heard(mru(i, 5'000 * static_cast<std::int64_t>(i), "mru1"), written));
    if (i % 2 == 1) meter.take(heard(mru(i, 5'000 * static_cast<std::int64_t>(i), "mru2"), ++written));
  }
  const RateReport report = meter.report();
  ASSERT_EQ(report.instances.size(), 2u);
  EXPECT_EQ(report.instances[0].missing, 2u);
  EXPECT_DOUBLE_EQ(report.instances[0].made_hz.value(), 200);
  EXPECT_NEAR(report.instances[0].on_bus_hz.value(), 47 / 0.245, 1e-9);
  EXPECT_EQ(report.instances[1].missing, 24u);  // never written: half of them only
  EXPECT_DOUBLE_EQ(report.instances[1].on_bus_hz.value(), 100);
  EXPECT_EQ(report.lost_on_dds, 2u);  // written, but not heard
}

TEST(RateMeter, ToldJitterIsTheDistanceFromTheMedianPeriod) {
  RateMeter meter{*topic_named("motionlab/mru")};
  std::int64_t t_us = 0;
  for (std::uint64_t i = 1; i <= 101; ++i) {
    meter.take(heard(mru(i, t_us), i));
    t_us += i == 50 ? 5'900 : i % 10 == 0 ? 5'100 : 5'000;
  }
  const InstanceRate rate = meter.report().instances[0];
  EXPECT_DOUBLE_EQ(rate.period_ms.value(), 5);
  EXPECT_EQ(rate.jitter_us.count, 100u);
  EXPECT_DOUBLE_EQ(rate.jitter_us.p50, 0);
  EXPECT_DOUBLE_EQ(rate.jitter_us.p95, 100);
  EXPECT_DOUBLE_EQ(rate.jitter_us.max, 900);
}

TEST(RateMeter, SpreadsTheTimeOfAGapOverItsNumbers) {
  RateMeter meter{*topic_named("motionlab/mru")};
  for (const std::uint64_t i : {1u, 2u, 12u, 13u})
    meter.take(heard(mru(i, 5'000 * static_cast<std::int64_t>(i)), i));
  EXPECT_DOUBLE_EQ(meter.report().instances[0].jitter_us.max, 0);
  EXPECT_EQ(meter.report().instances[0].missing, 9u);
}

TEST(RateMeter, TellsWhatAPacedTopicIsMadeAtAndWhatIsOnTheBus) {
  RateMeter meter{*topic_named("motionlab/estimate")};
  for (std::uint64_t i = 1; i <= 101; ++i) {
    topic::Estimate estimate;
    estimate.sequence_number = 5 * i;
    estimate.t_computed_ns = 1'000'000 * static_cast<std::int64_t>(5 * i);
    meter.take(heard(estimate, i));
  }
  const RateReport report = meter.report();
  EXPECT_DOUBLE_EQ(report.instances[0].made_hz.value(), 1000);
  EXPECT_DOUBLE_EQ(report.instances[0].on_bus_hz.value(), 200);
  EXPECT_EQ(report.lost_on_dds, 0u);
}

TEST(RateMeter, UsesTheSourceTimestampWhereATopicHasNoStampOfItsOwn) {
  RateMeter meter{*topic_named("motionlab/mode")};
  EXPECT_EQ(meter.stamp(), "DDS source timestamp");
  for (std::uint64_t i = 1; i <= 3; ++i) {
    topic::Mode mode;
    mode.sequence_number = i;
    HeardSample sample = heard(mode, i);
    sample.t_written_ns = 500'000'000 * static_cast<std::int64_t>(i);
    meter.take(sample);
  }
  EXPECT_DOUBLE_EQ(meter.report().instances[0].on_bus_hz.value(), 2);
}

TEST(RateMeter, TellsNoRateOfASingleSampleOrOfStampsThatStand) {
  RateMeter meter{*topic_named("motionlab/mru")};
  meter.take(heard(mru(1, 7), 1));
  EXPECT_EQ(meter.report().instances[0].on_bus_hz, std::nullopt);
  meter.take(heard(mru(2, 7), 2));
  EXPECT_EQ(meter.report().instances[0].on_bus_hz, std::nullopt);
  EXPECT_EQ(meter.report().heard, 2u);
}

TEST(RateMeter, BelievesNeitherRefusedSamplesNorSignsOfLeaving) {
  RateMeter meter{*topic_named("motionlab/mru")};
  HeardSample refused = heard(mru(1, 7), 1);
  refused.refusal = bus::Refusal::not_finite;
  meter.take(refused);
  HeardSample leaving = heard(mru(2, 8), 2);
  leaving.data = false;
  meter.take(leaving);
  meter.take(heard(mru(3, 9), 3));
  const RateReport report = meter.report();
  EXPECT_EQ(report.heard, 1u);
  EXPECT_EQ(report.refused, 1u);
  EXPECT_EQ(report.lost_on_dds, 0u);
}

TEST(RateMeter, KeepsTwoWritersOfOneDeviceApart) {
  RateMeter meter{*topic_named("motionlab/mru")};
  for (std::uint64_t i = 1; i <= 5; ++i) {
    meter.take(heard(mru(i, 5'000 * static_cast<std::int64_t>(i)), i, 1));
    meter.take(heard(mru(1000 + i, 5'000 * static_cast<std::int64_t>(i)), 70 + i, 2));
  }
  const RateReport report = meter.report();
  ASSERT_EQ(report.instances.size(), 2u);
  for (const InstanceRate& rate : report.instances) EXPECT_EQ(rate.missing + rate.restarts, 0u);
  EXPECT_EQ(report.lost_on_dds, 0u);
}

TEST(RateMeter, DoesNotCallLostOnDdsWhatThisProgramDidNotLookAt) {
  RateMeter meter{*topic_named("motionlab/mru")};
  meter.take(heard(mru(1, 5'000), 1));
  meter.take(heard(mru(11, 55'000), 11));
  EXPECT_EQ(meter.report(7).lost_on_dds, 2u);
  EXPECT_EQ(meter.report(7).overflowed, 7u);
}

TEST(RateMeter, SurvivesAnyNumbersAndStamps) {
  RateMeter meter{*topic_named("motionlab/mru")};
  topic::Mru sample;
  std::uint64_t written = 0;
  for (const std::uint64_t number : {std::uint64_t{0}, ~std::uint64_t{0}, std::uint64_t{1} << 63}) {
    for (const std::int64_t stamp : {std::int64_t{1} << 62, -(std::int64_t{1} << 62), std::int64_t{0}}) {
      sample.sequence_number = number;
      sample.t_measured_ns = stamp;
      meter.take(heard(sample, ++written));
    }
  }
  EXPECT_EQ(meter.report().heard, 9u);
}

TEST(Percentiles, AreTheSamplesAtTheirRanks) {
  std::vector<double> samples;
  for (int i = 100; i >= 1; --i) samples.push_back(i);
  const Percentiles percentiles = percentiles_of(samples);
  EXPECT_EQ(percentiles.count, 100u);
  EXPECT_EQ(percentiles.min, 1);
  EXPECT_EQ(percentiles.p50, 50);
  EXPECT_EQ(percentiles.p95, 95);
  EXPECT_EQ(percentiles.p99, 99);
  EXPECT_EQ(percentiles.max, 100);
  EXPECT_EQ(percentiles_of({3.0}).p50, 3);
  EXPECT_EQ(percentiles_of({}).count, 0u);
}

}  // namespace
}  // namespace motionlab::monitor
