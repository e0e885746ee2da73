// From the thread that hears to the one that writes: nobody waits, and what is lost is counted where it was
// lost.
#include "gateway/record/sample_queue.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

#include "tests/unit/record/heard.hpp"

namespace motionlab::record {
namespace {

constexpr std::size_t kMru = bus::topic_index<topic::Mru>();

std::vector<SampleToRecord> taken(SampleQueue& queue) {
  std::vector<SampleToRecord> all;
  while (queue.pop([&](const SampleToRecord& sample, Bytes) { all.push_back(sample); })) continue;
  return all;
}

TEST(SampleQueue, HandsOverWhatWasHeardWithItsBytes) {
  SampleQueue queue(1 << 16);
  topic::Mru mru;
  mru.device = "mru1";
  mru.sequence_number = 77;
  const Heard heard(mru, 5, 2'000);
  ASSERT_TRUE(queue.push(heard.sample()));
  bool seen = false;
  ASSERT_TRUE(queue.pop([&](const SampleToRecord& sample, Bytes cdr) {
    EXPECT_EQ(sample.topic, kMru);
    EXPECT_EQ(sample.sequence, 5U);
    EXPECT_EQ(sample.t_heard_ns, 2'000);
    EXPECT_EQ(sample.t_written_ns, 1'000);
    topic::Mru back;
    ASSERT_TRUE(read_cdr(cdr, back));
    EXPECT_EQ(back.sequence_number, 77U);
    seen = true;
  }));
  EXPECT_TRUE(seen);
  EXPECT_FALSE(queue.pop([](const SampleToRecord&, Bytes) { FAIL() << "it was the only one"; }));
}

TEST(SampleQueue, CountsWhatFindsNoRoomAndNeverCallsItLostOnDds) {
  SampleQueue queue(1024);
  std::uint64_t refused = 0;
  for (std::uint64_t number = 1; number <= 20; ++number)
    refused += queue.push(Heard(topic::Mru{}, number, 0).sample()) ? 0 : 1;
  EXPECT_GT(refused, 10U);
  EXPECT_EQ(queue.ledger().of(kMru), (TopicLosses{.in_queue = refused}));
  EXPECT_EQ(taken(queue).size(), 20 - refused);
  ASSERT_TRUE(queue.push(Heard(topic::Mru{}, 21, 0).sample()));
  EXPECT_EQ(taken(queue).at(0).losses, (TopicLosses{.in_queue = refused})) << "the next one tells of them";
}

TEST(SampleQueue, CountsGapsInTheNumbersOfEachWriter) {
  SampleQueue queue(1 << 20);
  for (const std::uint64_t number : {10U, 11U, 14U})
    (void)queue.push(Heard(topic::Mru{}, number, 0, 1).sample());
  for (const std::uint64_t number : {1U, 3U}) (void)queue.push(Heard(topic::Mru{}, number, 0, 2).sample());
  EXPECT_EQ(queue.ledger().of(kMru).on_dds, 3U);
  (void)queue.push(Heard(topic::Mru{}, 13, 0, 1).sample());
  EXPECT_EQ(queue.ledger().of(kMru).on_dds, 2U) << "it was only late";
  EXPECT_EQ(queue.ledger().of(bus::topic_index<topic::Event>()), TopicLosses{});
  EXPECT_EQ(taken(queue).back().losses.on_dds, 2U);
}

TEST(SampleQueue, BelievesNoImpossibleStampOfAStranger) {
  SampleQueue queue(1 << 16);
  const Heard heard(topic::Mru{}, 1, 5'000);
  for (const std::int64_t t : {std::int64_t{-1}, std::numeric_limits<std::int64_t>::max()}) {
    bus::TappedSample sample = heard.sample();
    sample.t_written_ns = t;
    (void)queue.push(sample);
    EXPECT_EQ(taken(queue).at(0).t_written_ns, 5'000);
  }
}

TEST(LossLedger, ForgetsNoTopicForATopicWithTooManyWriters) {
  LossLedger ledger;
  bus::DdsId writer;
  for (std::size_t i = 0; i < LossLedger::kMaxWriters + 10; ++i) {
    writer.bytes[0] = static_cast<std::uint8_t>(i);
    writer.bytes[1] = static_cast<std::uint8_t>(i >> 8);
    ledger.heard(kMru, writer, 1);
    ledger.heard(kMru, writer, 3);
  }
  EXPECT_EQ(ledger.of(kMru).on_dds, LossLedger::kMaxWriters);
}

}  // namespace
}  // namespace motionlab::record
