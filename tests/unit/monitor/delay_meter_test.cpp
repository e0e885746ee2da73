#include "gateway/monitor/delay_meter.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "gateway/monitor/delay_command.hpp"
#include "idl/control.hpp"
#include "idl/estimate.hpp"
#include "idl/mru.hpp"

namespace motionlab::monitor {
namespace {

using testing::HasSubstr;
using testing::Not;

/// In us after an hour that is far from zero, so that rounding would be seen.
constexpr std::int64_t kHour = 1'795'551'348'000'000'000;
constexpr std::int64_t at_us(std::int64_t us) {
  return kHour + 1000 * us;
}

template <class T>
void give(DelayMeter& meter, const T& sample, std::int64_t t_written_us, std::int64_t t_heard_us) {
  HeardSample heard;
  heard.values = values_of(sample);
  heard.instance = instance_of(sample);
  heard.t_written_ns = at_us(t_written_us);
  heard.t_heard_ns = at_us(t_heard_us);
  meter.take(*topic_of_type(T::kTypeName), heard);
}

topic::Mru mru(std::int64_t t_measured_us, std::int64_t t_received_us) {
  topic::Mru sample;
  sample.device = "mru1";
  sample.t_measured_ns = at_us(t_measured_us);
  sample.t_received_ns = at_us(t_received_us);
  return sample;
}

topic::Control control(std::int64_t t_snapshot_us, double age_mru_us) {
  topic::Control sample;
  sample.t_snapshot_ns = at_us(t_snapshot_us);
  sample.age_mru_s = 1e-6 * age_mru_us;
  sample.age_bodies_s = sample.age_arm_s = sample.age_winch_s = -1;  // not heard yet
  sample.step_time_us = 25;
  return sample;
}

Percentiles of(const DelayMeter& meter, Hop hop, std::string_view what) {
  for (const HopDelay& found : meter.report()) {
    if (found.hop == hop && found.what == what) return found.delay_us;
  }
  return {};
}

TEST(DelayMeter, FollowsASampleFromTheDeviceToTheReader) {
  DelayMeter meter;
  give(meter, mru(0, 2'000), 2'300, 2'450);
  give(meter, mru(5'000, 7'100), 7'300, 7'500);
  give(meter, control(8'000, 3'000), 8'125, 8'175);

  EXPECT_EQ(of(meter, Hop::link, "mru1").p50, 2'000);
  EXPECT_EQ(of(meter, Hop::link, "mru1").max, 2'100);
  EXPECT_EQ(of(meter, Hop::snapshot, "mru").count, 1u);
  EXPECT_EQ(of(meter, Hop::snapshot, "mru").p50, 900);
  EXPECT_EQ(of(meter, Hop::actuation, "mru").p50, 3'000);
  EXPECT_EQ(of(meter, Hop::control, "motionlab/control").p50, 25);
  EXPECT_EQ(of(meter, Hop::publish, "motionlab/mru").p50, 200);
  EXPECT_EQ(of(meter, Hop::publish, "motionlab/control").p50, 100);  // after the step, which took 25
  EXPECT_EQ(of(meter, Hop::network, "motionlab/mru").max, 200);
  EXPECT_EQ(of(meter, Hop::network, "motionlab/control").p50, 50);
}

TEST(DelayMeter, FindsTheSampleBehindAStepWhicheverArrivesFirst) {
  DelayMeter meter;
  give(meter, control(8'000, 3'000), 8'100, 8'150);
  EXPECT_EQ(of(meter, Hop::snapshot, "mru").count, 0u);
  give(meter, mru(5'000, 7'100), 7'300, 9'500);
  EXPECT_EQ(of(meter, Hop::snapshot, "mru").p50, 900);
}

TEST(DelayMeter, TakesNoNeighbourForTheSampleBehindAStep) {
  DelayMeter meter;
  give(meter, mru(4'999, 7'100), 7'300, 7'500);
  give(meter, mru(5'001, 7'100), 7'300, 7'500);
  give(meter, control(8'000, 3'000), 8'100, 8'150);
  EXPECT_EQ(of(meter, Hop::snapshot, "mru").count, 0u);
}

TEST(DelayMeter, TellsHowLongAnEstimateTakes) {
  DelayMeter meter;
  topic::Estimate estimate;
  estimate.t_estimated_ns = at_us(1'000);
  estimate.t_computed_ns = at_us(1'015);
  give(meter, estimate, 1'115, 1'200);
  EXPECT_EQ(of(meter, Hop::estimate, "motionlab/estimate").p50, 15);
  EXPECT_EQ(of(meter, Hop::publish, "motionlab/estimate").p50, 100);
}

TEST(DelayMeter, CountsStampsInTheWrongOrder) {
  DelayMeter meter;
  give(meter, mru(0, 2'000), 1'500, 3'000);
  const std::vector<HopDelay> report = meter.report();
  const auto publish = std::ranges::find(report, Hop::publish, &HopDelay::hop);
  ASSERT_NE(publish, report.end());
  EXPECT_EQ(publish->negative, 1u);
  EXPECT_EQ(publish->delay_us.p50, -500);
  EXPECT_THAT(delay_text(report, {}), HasSubstr("A negative delay means that the two clocks"));
}

TEST(DelayMeter, SurvivesAnyStampsAndAges) {
  DelayMeter meter;
  for (const std::int64_t t :
       {std::numeric_limits<std::int64_t>::min(), std::numeric_limits<std::int64_t>::max()}) {
    topic::Mru sample;
    sample.t_measured_ns = t;
    sample.t_received_ns = -(t / 2);
    give(meter, sample, 0, 1);
    topic::Control step;
    step.t_snapshot_ns = t;
    give(meter, step, 0, 1);
  }
  for (const double age :
       {1e300, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    topic::Control step = control(1, 1);
    step.age_mru_s = step.step_time_us = age;
    give(meter, step, 0, 1);
  }
  EXPECT_EQ(of(meter, Hop::actuation, "mru").count, 0u);
  EXPECT_EQ(of(meter, Hop::link, "").count, 0u);
}

TEST(DelayText, SaysWhatItAssumesOfTheClocks) {
  DelayMeter meter;
  give(meter, mru(0, 2'000), 2'300, 2'450);
  EXPECT_THAT(delay_text(meter.report(), {}), HasSubstr("All writers are on this host"));
  const std::string far = delay_text(meter.report(), {"lab\033pc"});
  EXPECT_THAT(far, HasSubstr("Writers on other hosts (lab\\x1bpc)"));
  EXPECT_THAT(far, Not(HasSubstr("All writers are on this host")));
}

TEST(DelayText, IsOneLineForEachHopInTheOrderOfTheWay) {
  DelayMeter meter;
  give(meter, mru(0, 2'000), 2'300, 2'450);
  const std::string text = delay_text(meter.report(), {});
  EXPECT_THAT(text, testing::ContainsRegex("measured -> received +mru1 +1 +2000 +2000 +2000 +2000\n"));
  EXPECT_LT(text.find("measured -> received"), text.find("last stamp -> on DDS"));
  EXPECT_LT(text.find("last stamp -> on DDS"), text.find("on DDS -> heard here"));
}

TEST(DelayJson, HasTheSameNumbers) {
  DelayMeter meter;
  give(meter, mru(0, 2'000), 2'300, 2'450);
  const auto json = delay_json(meter.report(), {"far"});
  EXPECT_EQ(json["other_hosts"][0], "far");
  ASSERT_EQ(json["hops"].size(), 3u);
  EXPECT_EQ(json["hops"][0]["hop"], "measured -> received");
  EXPECT_EQ(json["hops"][0]["of"], "mru1");
  EXPECT_EQ(json["hops"][0]["p99"], 2000.0);
  EXPECT_EQ(json["hops"][0]["crosses_clocks"], false);
  EXPECT_EQ(json["hops"][2]["crosses_clocks"], true);
}

}  // namespace
}  // namespace motionlab::monitor
