// Samples into files: parts, caps, chunks, ledgers, and what is left when the disk is full or the writer
// dies.
#include "gateway/record/recording.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <malloc.h>
#include <signal.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <set>
#include <string>
#include <vector>

#include "drivers/core/error.hpp"
#include "gateway/record/mcap_reader.hpp"
#include "tests/unit/record/heard.hpp"

namespace motionlab::record {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
namespace fs = std::filesystem;

constexpr auto kChunkSamples = static_cast<std::uint64_t>(Recording::kChunk / 5ms);

struct Contents {
  std::vector<std::uint64_t> numbers;  ///< of the mru's samples
  std::vector<McapMetadata> metadata;
  std::vector<std::string> attached;
  std::set<std::string> topics;
  bool complete = false;

  [[nodiscard]] StringMap about(std::string_view name, const std::string& key,
                                const std::string& value) const {
    for (const McapMetadata& entry : metadata) {
      const auto found = entry.values.find(key);
      if (entry.name == name && found != entry.values.end() && found->second == value) return entry.values;
    }
    return {};
  }
};

Contents read(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  McapReader reader(in);
  Contents contents;
  for (;;) {
    const auto item = reader.next();
    if (!item) {
      ADD_FAILURE() << file << ": " << item.fault().text;
      break;
    }
    if (!item->has_value()) break;
    if (const auto* message = std::get_if<McapMessage>(&**item)) {
      contents.topics.insert(message->channel->topic);
      topic::Mru mru;
      if (message->channel->topic == "motionlab/mru" && read_cdr(message->data, mru))
        contents.numbers.push_back(mru.sequence_number);
    } else if (const auto* metadata = std::get_if<McapMetadata>(&**item)) {
      contents.metadata.push_back(*metadata);
    } else {
      const auto& attachment = std::get<McapAttachment>(**item);
      contents.attached.push_back(attachment.name + ": " + std::string(as_text(attachment.data)));
    }
  }
  contents.complete = reader.complete();
  return contents;
}

class RecordingTest : public testing::Test {
 protected:
  RecordingTest()
      : folder_(fs::path(testing::TempDir()) / ("motionlab-recording-" + std::to_string(getpid()))) {
    fs::create_directories(folder_);
  }
  ~RecordingTest() override { fs::remove_all(folder_); }

  RecordingOptions options() const { return {.file = folder_ / "run.mcap"}; }

  /// A sample every 5 ms, all of them different so that they do not pack well.
  void feed(Recording& recording, std::uint64_t count) {
    for (std::uint64_t i = 0; i < count; ++i) {
      topic::Mru mru;
      mru.device = "mru1";
      mru.sequence_number = ++number_;
      for (double& x : mru.a_mru_mps2) x = static_cast<double>(number_ * 0x9E3779B97F4A7C15ULL);
      for (double& x : mru.v_mru_mps) x = static_cast<double>(number_ * 0xD1B54A32D192ED03ULL);
      push(mru, number_);
      drain(recording);
      recording.keep_up(now());
    }
  }
  template <class T>
  void push(const T& sample, std::uint64_t sequence) {
    (void)queue_.push(Heard(sample, sequence, to_ns(now())).sample());
  }
  void drain(Recording& recording) {
    while (queue_.pop([&](const SampleToRecord& sample, Bytes cdr) { recording.take(sample, cdr); }))
      continue;
  }
  [[nodiscard]] LabTime now() const {
    return LabTime{} + 1'000'000s + 5ms * static_cast<std::int64_t>(number_);
  }

  fs::path folder_;
  SampleQueue queue_{1 << 20};
  std::uint64_t number_ = 0;
};

TEST_F(RecordingTest, IsAWholeFileWithItsOrigin) {
  RecordingOptions wanted = options();
  wanted.attached.push_back({"lab.toml", "application/toml", "[control]\n"});
  wanted.about["topics"] = "all";
  Recording recording(wanted, now());
  feed(recording, 300);
  push(topic::Event{}, 1);
  drain(recording);
  recording.finish(queue_.ledger().all());
  EXPECT_FALSE(recording.trouble());
  EXPECT_EQ(recording.messages(), 301U);
  EXPECT_EQ(recording.bytes(), fs::file_size(folder_ / "run.mcap"));
  const Contents contents = read(folder_ / "run.mcap");
  EXPECT_TRUE(contents.complete);
  EXPECT_EQ(contents.numbers.size(), 300U);
  EXPECT_EQ(contents.topics, (std::set<std::string>{"motionlab/event", "motionlab/mru"}));
  EXPECT_THAT(contents.attached, ElementsAre("lab.toml: [control]\n"));
  const StringMap about = contents.about(kRecordingMetadata, "part", "1");
  EXPECT_EQ(about.at("topics"), "all");
  EXPECT_EQ(about.at("began"), "1970-01-12T13:46:40Z");
  EXPECT_FALSE(about.at("version").empty());
}

TEST_F(RecordingTest, NeverWritesOverAFile) {
  std::ofstream(folder_ / "run.mcap") << "of value";
  Recording recording(options(), now());
  recording.finish({});
  EXPECT_THAT(recording.files(), ElementsAre(folder_ / "run-2.mcap"));
  EXPECT_EQ(fs::file_size(folder_ / "run.mcap"), 8U);
}

TEST_F(RecordingTest, SaysWhyItCannotBegin) {
  RecordingOptions wanted = options();
  wanted.file = folder_ / "nowhere" / "run.mcap";
  try {
    const Recording recording(wanted, now());
    FAIL() << "there is no such folder";
  } catch (const StartupError& error) {
    EXPECT_THAT(error.what(), HasSubstr("No such file or directory; choose a folder"));
  }
}

TEST_F(RecordingTest, BeginsANewPartWhenOneIsLongEnough) {
  RecordingOptions wanted = options();
  wanted.split_bytes = 10'000;
  Recording recording(wanted, now());
  feed(recording, 2000);
  recording.finish(queue_.ledger().all());
  ASSERT_GT(recording.files().size(), 2U);
  EXPECT_EQ(recording.files()[1], folder_ / "run-part2.mcap");
  std::vector<std::uint64_t> all;
  int part = 0;
  for (const fs::path& file : recording.files()) {
    const Contents contents = read(file);
    EXPECT_TRUE(contents.complete) << file;
    all.insert(all.end(), contents.numbers.begin(), contents.numbers.end());
    const std::string number = std::to_string(++part);
    EXPECT_FALSE(contents.about(kRecordingMetadata, "part", number).empty()) << file;
    EXPECT_EQ(contents.about(kLossMetadata, "topic", "motionlab/mru").at("messages"),
              std::to_string(contents.numbers.size()));
  }
  ASSERT_EQ(all.size(), 2000U) << "nothing is lost between two parts";
  for (std::size_t i = 0; i < all.size(); ++i) ASSERT_EQ(all[i], i + 1);
}

TEST_F(RecordingTest, KeepsTheNewestPartsWithinItsShareOfTheDisk) {
  RecordingOptions wanted = options();
  wanted.split_bytes = 20'000;
  wanted.disk_bytes = 100'000;
  Recording recording(wanted, now());
  std::uint64_t most = 0;
  for (int i = 0; i < 100; ++i) {
    feed(recording, 100);
    std::uint64_t used = 0;
    for (const auto& entry : fs::directory_iterator(folder_)) used += entry.file_size();
    most = std::max(most, used);
  }
  recording.finish(queue_.ledger().all());
  EXPECT_LT(most, wanted.disk_bytes + wanted.split_bytes);
  EXPECT_GT(most, wanted.disk_bytes / 2);
  EXPECT_FALSE(fs::exists(folder_ / "run.mcap")) << "the oldest goes first";
  EXPECT_EQ(read(recording.files().back()).numbers.back(), number_) << "the newest is there";
}

TEST_F(RecordingTest, TellsWhatIsLostInThePartWhereItIsMissing) {
  RecordingOptions wanted = options();
  wanted.split_bytes = 5'000;
  Recording recording(wanted, now());
  feed(recording, 10);
  number_ += 3;  // lost on DDS
  feed(recording, 600);
  ASSERT_GT(recording.files().size(), 1U);
  queue_.ledger().dropped(bus::topic_index<topic::Mru>());
  queue_.ledger().refused(bus::topic_index<topic::Event>(), 2);
  recording.finish(queue_.ledger().all());
  const StringMap first = read(recording.files().front()).about(kLossMetadata, "topic", "motionlab/mru");
  EXPECT_EQ(first.at("lost_on_dds"), "3");
  EXPECT_EQ(first.at("lost_in_queue"), "0");
  const Contents last = read(recording.files().back());
  EXPECT_EQ(last.about(kLossMetadata, "topic", "motionlab/mru").at("lost_on_dds"), "0");
  EXPECT_EQ(last.about(kLossMetadata, "topic", "motionlab/mru").at("lost_in_queue"), "1");
  EXPECT_EQ(last.about(kLossMetadata, "topic", "motionlab/event").at("refused"), "2") << "though it has none";
}

TEST_F(RecordingTest, TellsWhatTheDevicesLinksLost) {
  Recording recording(options(), now());
  topic::Health health;
  health.device = "mru1";
  const auto tell = [&](std::uint64_t received, std::uint64_t lost, std::uint64_t rejected) {
    health.received = received;
    health.lost = lost;
    health.rejected[3] = rejected;
    push(health, ++number_);
    drain(recording);
  };
  tell(1000, 7, 1);
  tell(1100, 8, 1);
  tell(1200, 9, 4);
  recording.finish(queue_.ledger().all());
  const StringMap wire = read(folder_ / "run.mcap").about(kWireMetadata, "device", "mru1");
  EXPECT_EQ(wire.at("received"), "200");
  EXPECT_EQ(wire.at("lost"), "2");
  EXPECT_EQ(wire.at("rejected"), "3");
  EXPECT_EQ(wire.at("reconnects"), "0");
}

TEST_F(RecordingTest, HasAllButTheLastMomentWhenItsProcessDies) {
  Recording recording(options(), now());
  feed(recording, 1000);
  // What another process sees of the file now is what a kill would leave.
  const Contents contents = read(folder_ / "run.mcap");
  EXPECT_FALSE(contents.complete);
  ASSERT_FALSE(contents.numbers.empty());
  EXPECT_GE(contents.numbers.back() + kChunkSamples + 1, number_);
  recording.finish({});
}

TEST_F(RecordingTest, EndsWithAWordWhenTheDiskIsFullAndKeepsWhatIsThere) {
  signal(SIGXFSZ, SIG_IGN);
  const rlimit limit{60'000, RLIM_INFINITY};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &limit), 0);
  Recording recording(options(), now());
  while (!recording.trouble()) feed(recording, 100);
  const std::uint64_t full_at = number_;
  recording.finish(queue_.ledger().all());
  const rlimit none{RLIM_INFINITY, RLIM_INFINITY};
  setrlimit(RLIMIT_FSIZE, &none);
  EXPECT_THAT(recording.trouble().value_or(""), HasSubstr("disk takes no more"));
  const Contents contents = read(folder_ / "run.mcap");
  EXPECT_FALSE(contents.complete);
  ASSERT_FALSE(contents.numbers.empty());
  for (std::size_t i = 0; i < contents.numbers.size(); ++i) ASSERT_EQ(contents.numbers[i], i + 1);
  EXPECT_GE(contents.numbers.size() + 2 * kChunkSamples + 100, full_at);
}

TEST_F(RecordingTest, GrowsNoMemoryInADay) {
  RecordingOptions wanted = options();
  wanted.split_bytes = 200'000;
  wanted.disk_bytes = 1'000'000;
  Recording recording(wanted, now());
  std::size_t in_the_morning = 0;
  constexpr int kDay_s = 24 * 3600;
  for (int second = 0; second < kDay_s; ++second) {
    topic::Health health;
    health.device = "mru1";
    push(health, static_cast<std::uint64_t>(second));
    number_ += static_cast<std::uint64_t>(1s / 5ms);  // of time
    drain(recording);
    recording.keep_up(now());
    if (second == kDay_s / 24) in_the_morning = mallinfo2().uordblks;
  }
  EXPECT_LE(mallinfo2().uordblks, in_the_morning + 128 * 1024) << "one index of a part more or less";
  recording.finish(queue_.ledger().all());
  EXPECT_GT(recording.messages(), 86'000U);
}

TEST_F(RecordingTest, IsNamedByTheDate) {
  EXPECT_EQ(dated_name(LabTime{} + 1'796'005'800s), "motionlab-20261130T023000Z.mcap");
}

}  // namespace
}  // namespace motionlab::record
