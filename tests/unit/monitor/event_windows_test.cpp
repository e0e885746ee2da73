// Of a stream of samples, what surrounds certain events lies in files, and nothing else.
#include "gateway/monitor/event_windows.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

#include "gateway/record/cdr.hpp"
#include "gateway/record/mcap_reader.hpp"
#include "tests/unit/record/heard.hpp"

namespace motionlab::monitor {
namespace {

namespace fs = std::filesystem;
using record::Heard;
using record::StringMap;
using testing::ElementsAre;

constexpr LabTime kBorn = LabTime{} + std::chrono::seconds{1'800'000'000};

struct Part {
  std::vector<double> mrus_s;  ///< when they were heard
  int events = 0;
  StringMap occasion, mru_losses;
};

Part read(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  record::McapReader reader(in);
  Part part;
  for (;;) {
    const auto item = reader.next();
    if (!item || !item->has_value()) break;
    if (const auto* message = std::get_if<record::McapMessage>(&**item)) {
      if (message->channel->topic == "motionlab/event") ++part.events;
      if (message->channel->topic == "motionlab/mru")
        part.mrus_s.push_back(seconds(from_ns(static_cast<std::int64_t>(message->logged_ns)) - kBorn));
    } else if (const auto* metadata = std::get_if<record::McapMetadata>(&**item)) {
      if (metadata->name == record::kOccasionMetadata) part.occasion = metadata->values;
      if (metadata->name == record::kLossMetadata && metadata->values.at("topic") == "motionlab/mru")
        part.mru_losses = metadata->values;
    }
  }
  EXPECT_TRUE(reader.complete()) << file;
  return part;
}

class EventWindowsTest : public testing::Test {
 protected:
  EventWindowsTest()
      : folder_(fs::path(testing::TempDir()) / ("motionlab-windows-" + std::to_string(getpid()))) {
    fs::create_directories(folder_);
  }
  ~EventWindowsTest() override { fs::remove_all(folder_); }

  record::RecordingOptions options() const { return {.file = folder_ / "run.mcap", .on_occasion = true}; }
  static EventWindow window(std::vector<std::string> on) { return {std::move(on), 2s, 1s}; }

  /// A sample every 100 ms, until so long after the birth.
  void feed_until(EventWindows& windows, double end_s) {
    for (; now_ - kBorn < from_seconds(end_s); now_ += 100ms) {
      topic::Mru mru;
      mru.device = "mru1";
      mru.sequence_number = ++number_;
      tell(windows, mru, number_);
      windows.keep_up(now_);
    }
  }
  template <class T>
  void tell(EventWindows& windows, const T& sample, std::uint64_t sequence) {
    (void)queue_.push(Heard(sample, sequence, to_ns(now_)).sample());
    while (queue_.pop([&](const record::SampleToRecord& head, Bytes cdr) { windows.take(head, cdr); }))
      continue;
  }
  void happens(EventWindows& windows, topic::Severity severity, const std::string& code) {
    topic::Event event;
    event.severity = severity;
    event.source = "mru1";
    event.code = code;
    tell(windows, event, ++events_);
  }

  fs::path folder_;
  record::SampleQueue queue_{1 << 20};
  LabTime now_ = kBorn;
  std::uint64_t number_ = 0, events_ = 0;
};

TEST_F(EventWindowsTest, HaveWhatWasBeforeAndWhatCameAfter) {
  record::Recording recording(options(), kBorn);
  EventWindows windows(window({"fault"}), kBorn, recording);
  feed_until(windows, 5);
  EXPECT_TRUE(fs::is_empty(folder_)) << "nothing has happened";
  happens(windows, topic::Severity::fault, "mru1_stale");
  feed_until(windows, 20);
  EXPECT_THAT(recording.files(), ElementsAre(folder_ / "run.mcap"));
  const Part part = read(folder_ / "run.mcap");
  ASSERT_FALSE(part.mrus_s.empty());
  EXPECT_NEAR(part.mrus_s.front(), 3.0, 0.11);
  EXPECT_NEAR(part.mrus_s.back(), 6.0, 0.11);
  EXPECT_EQ(part.mrus_s.size(), 30U) << "each once, none left out";
  EXPECT_EQ(part.events, 1);
  EXPECT_EQ(part.occasion.at("code"), "mru1_stale");
  EXPECT_EQ(part.occasion.at("severity"), "fault");
  EXPECT_EQ(part.occasion.at("before_s"), "2.000");
  EXPECT_EQ(recording.bytes(), fs::file_size(folder_ / "run.mcap"));
}

TEST_F(EventWindowsTest, EachHaveAPartOfTheirOwnAndOneThatIsOpenGrows) {
  record::Recording recording(options(), kBorn);
  EventWindows windows(window({"warning", "engaged"}), kBorn, recording);
  feed_until(windows, 5);
  happens(windows, topic::Severity::info, "engaged");
  feed_until(windows, 5.5);
  happens(windows, topic::Severity::fault, "arm_stale");  // more severe than asked for: counts as well
  feed_until(windows, 10);
  happens(windows, topic::Severity::info, "something else");
  feed_until(windows, 15);
  happens(windows, topic::Severity::warning, "late");
  feed_until(windows, 20);
  EXPECT_EQ(windows.count(), 2U);
  ASSERT_THAT(recording.files(), ElementsAre(folder_ / "run.mcap", folder_ / "run-part2.mcap"));
  EXPECT_NEAR(read(recording.files()[0]).mrus_s.back(), 6.5, 0.11);
  EXPECT_EQ(read(recording.files()[0]).events, 2);
  EXPECT_EQ(read(recording.files()[1]).occasion.at("code"), "late");
}

TEST_F(EventWindowsTest, AreOpenedByNoEventFromBeforeTheirTime) {
  record::Recording recording(options(), kBorn);
  EventWindows windows(window({"info"}), kBorn, recording);
  // As DDS hands them to those who come late: heard now, written before.
  now_ = kBorn;
  happens(windows, topic::Severity::fault, "old");  // written a microsecond before
  feed_until(windows, 5);
  EXPECT_EQ(windows.count(), 0U);
}

TEST_F(EventWindowsTest, EndThoughTheBusFallsSilent) {
  record::Recording recording(options(), kBorn);
  EventWindows windows(window({"fault"}), kBorn, recording);
  feed_until(windows, 3);
  happens(windows, topic::Severity::fault, "gateway_gone");
  windows.keep_up(now_ + 10s);
  EXPECT_TRUE(read(folder_ / "run.mcap").occasion.contains("code")) << "whole, with its end";
}

TEST_F(EventWindowsTest, TellOnlyTheirOwnLosses) {
  record::Recording recording(options(), kBorn);
  EventWindows windows(window({"fault"}), kBorn, recording);
  feed_until(windows, 1);
  number_ += 50;  // lost on DDS, long before
  feed_until(windows, 10);
  number_ += 3;
  feed_until(windows, 11);
  happens(windows, topic::Severity::fault, "arm_stale");
  feed_until(windows, 13);
  number_ += 7;  // behind the window's end
  feed_until(windows, 20);
  recording.finish(queue_.ledger().all());
  const StringMap losses = read(folder_ / "run.mcap").mru_losses;
  EXPECT_EQ(losses.at("lost_on_dds"), "3");
  EXPECT_EQ(losses.at("messages"), "30");
}

TEST_F(EventWindowsTest, HoldNoMoreThanTheyMayAndSayFromWhenTheyAreWhole) {
  record::Recording recording(options(), kBorn);
  EventWindows windows(window({"fault"}), kBorn, recording, 4096);
  feed_until(windows, 10);
  happens(windows, topic::Severity::fault, "arm_stale");
  feed_until(windows, 15);
  const Part part = read(folder_ / "run.mcap");
  EXPECT_LT(part.mrus_s.size(), 25U);
  ASSERT_FALSE(part.mrus_s.empty());
  EXPECT_NEAR(std::stod(part.occasion.at("before_s")), 10.0 - part.mrus_s.front(), 0.001);
}

TEST_F(EventWindowsTest, TakeAStrangersSeverityAsItIs) {
  record::Recording recording(options(), kBorn);
  EventWindows windows(window({"strange"}), kBorn, recording);
  feed_until(windows, 1);
  happens(windows, static_cast<topic::Severity>(77), "strange");
  feed_until(windows, 5);
  EXPECT_EQ(windows.count(), 0U) << "it is no event of ours";
}

TEST_F(EventWindowsTest, StopWhenTheDiskTakesNoMore) {
  record::RecordingOptions nowhere = options();
  record::Recording recording(nowhere, kBorn);
  EventWindows windows(window({"fault"}), kBorn, recording);
  feed_until(windows, 1);
  fs::remove_all(folder_);
  happens(windows, topic::Severity::fault, "arm_stale");
  EXPECT_TRUE(recording.trouble());
  feed_until(windows, 5);
  EXPECT_TRUE(recording.trouble());
}

}  // namespace
}  // namespace motionlab::monitor
