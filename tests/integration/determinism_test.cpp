// The same configuration is the same run, to the bit.
#include <gtest/gtest.h>

#include <string>
#include <tuple>
#include <vector>

#include "gateway/monitor/scorer.hpp"
#include "tests/integration/line.hpp"

namespace motionlab::integration {
namespace {

/// Everything that a run said: the report, and one hash over all samples of all topics.
struct Record {
  std::string report;
  std::uint64_t topics = 0;
  std::size_t samples = 0;
};

/// Subscriptions to every topic of the house.
class Everything {
 public:
  explicit Everything(bus::LocalBus& bus) : inboxes_(open(bus)) {}

  void drain(Hash& hash, std::size_t& samples) {
    std::apply(
        [&](auto&... inbox) {
          const auto one = [&](auto& each) {
            while (const auto sample = each.next()) {
              hash.add(*sample);
              ++samples;
            }
            EXPECT_EQ(each.lost(), 0U);
          };
          (one(inbox), ...);
        },
        inboxes_);
  }

 private:
  template <class... T>
  using Inboxes = std::tuple<bus::Subscription<T>...>;
  using All = Inboxes<topic::ArmCommand, topic::ArmState, topic::Bodies, topic::Control, topic::Estimate,
                      topic::Event, topic::Health, topic::Mode, topic::ModeRequest, topic::Mru,
                      topic::Reference, topic::WinchCommand, topic::WinchState>;
  static All open(bus::LocalBus& bus) {
    return {bus.subscribe<topic::ArmCommand>(),  bus.subscribe<topic::ArmState>(),
            bus.subscribe<topic::Bodies>(),      bus.subscribe<topic::Control>(),
            bus.subscribe<topic::Estimate>(),    bus.subscribe<topic::Event>(),
            bus.subscribe<topic::Health>(),      bus.subscribe<topic::Mode>(),
            bus.subscribe<topic::ModeRequest>(), bus.subscribe<topic::Mru>(),
            bus.subscribe<topic::Reference>(),   bus.subscribe<topic::WinchCommand>(),
            bus.subscribe<topic::WinchState>()};
  }
  All inboxes_;
};

Record record(std::uint64_t seed) {
  lockstep::Config config = configure("sea", seed);
  config.faults.push_back(lab::PlannedFault::parse("qualisys:loss=0.3@14..16"));
  config.faults.push_back(lab::PlannedFault::parse("mru1:silent@18"));
  lockstep::Lockstep line(config);
  line.network().set_datagram_fault(Endpoint::parse("127.0.0.1:50043"), {.loss = 0.02, .jitter = 1ms});
  Everything everything(line.bus());
  monitor::ScorerConfig scoring;
  scoring.t_start = LabTime{};
  scoring.score_from_s = 12;
  scoring.timing = false;
  monitor::Scorer scorer(scoring);
  auto control = line.bus().reader<topic::Control>();
  auto mode = line.bus().reader<topic::Mode>();
  Record record;
  Hash hash;
  while (line.now() < LabTime{} + 20s) {
    if (line.now() == LabTime{} + 10s) line.request(topic::ModeAction::engage);
    line.step();
    if (const auto sample = mode.newer()) scorer.take(*sample);
    if (const auto sample = control.newer()) scorer.take(*sample);
    const auto truth = line.lab().truth();
    hash.add(truth);
    scorer.take(truth);
    everything.drain(hash, record.samples);
  }
  record.report = monitor::to_json(scorer.report());
  record.topics = hash.value();
  return record;
}

TEST(Determinism, TheSameSeedIsTheSameRunToTheBit) {
  const Record first = record(3);
  const Record second = record(3);
  EXPECT_GT(first.samples, 100'000U);
  EXPECT_EQ(first.samples, second.samples);
  EXPECT_EQ(first.topics, second.topics);
  EXPECT_EQ(first.report, second.report);
  EXPECT_NE(first.report.find("mru1_stale"), std::string::npos) << first.report;
}

TEST(Determinism, AnotherSeedIsAnotherRun) {
  const Record first = record(3);
  const Record second = record(4);
  EXPECT_NE(first.topics, second.topics);
  EXPECT_NE(first.report, second.report);
}

}  // namespace
}  // namespace motionlab::integration
