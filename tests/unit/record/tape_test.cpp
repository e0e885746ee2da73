// From the control thread to the file: each step whole, or counted.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "drivers/core/error.hpp"
#include "gateway/record/byte_ring.hpp"
#include "gateway/record/mcap_reader.hpp"
#include "gateway/record/run_recorder.hpp"
#include "gateway/record/run_tape.hpp"
#include "tests/support/allocations.hpp"
#include "tests/unit/record/filled.hpp"

namespace motionlab::record {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

TEST(ByteRing, PiecesOfAnySizeComeOutInOrderOverItsEdge) {
  ByteRing ring(64);
  ByteBuffer out;
  for (std::uint8_t round = 0; round < 200; ++round) {
    const ByteBuffer first(static_cast<std::size_t>(round % 24), round), second(3, 0xaa);
    ASSERT_TRUE(ring.push(first));
    ASSERT_TRUE(ring.push(second));
    ASSERT_TRUE(ring.pop(out));
    EXPECT_EQ(out, first);
    ASSERT_TRUE(ring.pop(out));
    EXPECT_EQ(out, second);
    EXPECT_FALSE(ring.pop(out));
  }
}

TEST(ByteRing, WhatDoesNotFitIsRefusedAndWhatIsInStays) {
  ByteRing ring(64);
  EXPECT_FALSE(ring.push(ByteBuffer(61, 1)));
  ASSERT_TRUE(ring.push(ByteBuffer(40, 2)));
  EXPECT_FALSE(ring.push(ByteBuffer(17, 3)));
  ASSERT_TRUE(ring.push(ByteBuffer(16, 4)));
  ByteBuffer out;
  ASSERT_TRUE(ring.pop(out));
  EXPECT_EQ(out, ByteBuffer(40, 2));
  ASSERT_TRUE(ring.pop(out));
  EXPECT_EQ(out, ByteBuffer(16, 4));
}

TEST(ByteRing, HandsOverFromThreadToThread) {
  ByteRing ring(1024);
  constexpr std::uint32_t kPieces = 200'000;
  std::thread producer([&ring] {
    for (std::uint32_t i = 0; i < kPieces;) {
      const ByteBuffer piece(1 + i % 90, static_cast<std::uint8_t>(i));
      if (ring.push(piece)) {
        ++i;
      } else {
        std::this_thread::yield();
      }
    }
  });
  ByteBuffer out;
  std::uint32_t wrong = 0;
  for (std::uint32_t i = 0; i < kPieces;) {
    if (!ring.pop(out)) {
      std::this_thread::yield();
      continue;
    }
    if (out != ByteBuffer(1 + i % 90, static_cast<std::uint8_t>(i))) ++wrong;
    ++i;
  }
  producer.join();
  EXPECT_EQ(wrong, 0U);
}

/// A folder of the test's own.
class Recording : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::path(testing::TempDir()) /
              ("motionlab-record-" + std::to_string(getpid()) + "-" +
               testing::UnitTest::GetInstance()->current_test_info()->name());
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  static void step(RunTape& tape, std::uint64_t number) {
    topic::Snapshot inputs;
    inputs.sequence_number = number;
    inputs.t_ns = static_cast<std::int64_t>(number) * 1'000'000;
    inputs.mru.push(filled<topic::Mru>(number));
    tape.begin(inputs);
    tape.add(filled<topic::Estimate>(number));
    tape.add(filled<topic::Control>(number));
    tape.end();
  }

  /// Topics and times of the messages, names of the rest, in order.
  static std::vector<std::string> items(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    McapReader reader(in);
    std::vector<std::string> found;
    for (;;) {
      const auto item = reader.next();
      EXPECT_TRUE(item) << item.fault().text;
      if (!item || !item->has_value()) return found;
      if (const auto* message = std::get_if<McapMessage>(&**item)) {
        found.push_back(message->channel->topic + '@' + std::to_string(message->logged_ns / 1'000'000));
      } else if (const auto* metadata = std::get_if<McapMetadata>(&**item)) {
        std::string text = metadata->name;
        for (const auto& [key, value] : metadata->values) text += ' ' + key + '=' + value;
        found.push_back(text);
      } else {
        found.push_back(std::get<McapAttachment>(**item).name);
      }
    }
  }

  std::filesystem::path folder_;
};

TEST_F(Recording, HasConfigurationAndEveryStep) {
  RunTape tape;
  RunRecorder recorder(folder_ / "run.mcap", tape, "[control]\n");
  step(tape, 1);
  step(tape, 2);
  EXPECT_EQ(recorder.drain(), 2U);
  recorder.finish();
  EXPECT_FALSE(recorder.trouble());
  EXPECT_THAT(items(folder_ / "run.mcap"),
              ElementsAre(HasSubstr("motionlab/run outputs_every=1 version="), "gateway.toml",
                          "motionlab/snapshot@1", "motionlab/estimate@1", "motionlab/control@1",
                          "motionlab/snapshot@2", "motionlab/estimate@2", "motionlab/control@2"));
}

TEST_F(Recording, KeepsOutputsOfEverySoManyStepsAndAChecksumOfAll) {
  RunTape tape(2);
  RunRecorder recorder(folder_ / "run.mcap", tape, "[control]\n");
  step(tape, 1);
  const auto first = tape.outputs_crc();
  step(tape, 2);
  EXPECT_NE(tape.outputs_crc(), first) << "a step whose samples are not kept has a checksum, too";
  step(tape, 3);
  recorder.finish();
  const auto found = items(folder_ / "run.mcap");
  EXPECT_THAT(std::vector<std::string>(found.begin() + 2, found.end()),
              ElementsAre("motionlab/snapshot@1", "motionlab/estimate@1", "motionlab/control@1",
                          "motionlab/snapshot@2", "motionlab/snapshot@3", "motionlab/estimate@3",
                          "motionlab/control@3"));
}

TEST_F(Recording, TheChecksumLeavesOutWhatAStopwatchMeasured) {
  RunTape tape;
  auto control = filled<topic::Control>(1);
  tape.begin({});
  tape.add(control);
  const auto crc = tape.outputs_crc();
  control.step_time_us += 1;
  tape.begin({});
  tape.add(control);
  EXPECT_EQ(tape.outputs_crc(), crc);
  control.wire_speed_command_mps += 1e-18;
  control.qd_command_radps[5] = -control.qd_command_radps[5];
  tape.begin({});
  tape.add(control);
  EXPECT_NE(tape.outputs_crc(), crc);
}

TEST_F(Recording, StepsThatFindNoRoomAreAGapInTheFile) {
  RunTape tape(1, 4096);
  RunRecorder recorder(folder_ / "run.mcap", tape, "[control]\n");
  std::uint64_t number = 1;
  step(tape, number);
  (void)recorder.drain();
  while (tape.lost() < 3) step(tape, ++number);
  (void)recorder.drain();
  step(tape, ++number);
  (void)recorder.drain();
  while (tape.lost() < 5) step(tape, ++number);
  recorder.finish();
  const auto found = items(folder_ / "run.mcap");
  std::vector<std::string> gaps;
  for (const auto& item : found) {
    if (item.find("gap") != std::string::npos) gaps.push_back(item);
  }
  EXPECT_THAT(gaps, ElementsAre(testing::MatchesRegex("motionlab/gap before_step=[0-9]+ lost_steps=3"),
                                testing::MatchesRegex("motionlab/gap before_step=" +
                                                      std::to_string(number + 1) + " lost_steps=2")));
}

TEST_F(Recording, ADeadWriterLosesHalfASecondAtMost) {
  std::filesystem::copy_options overwrite = std::filesystem::copy_options::overwrite_existing;
  RunTape tape;
  RunRecorder recorder(folder_ / "run.mcap", tape, "[control]\n");
  for (std::uint64_t number = 1; number <= 1200; ++number) {
    step(tape, number);
    (void)recorder.drain();
    if (number % 100 != 0) continue;
    // What the disk has now is what a kill -9 leaves behind.
    std::filesystem::copy_file(folder_ / "run.mcap", folder_ / "left.mcap", overwrite);
    std::uint64_t steps = 0;
    for (const auto& item : items(folder_ / "left.mcap")) {
      if (item.find("snapshot") != std::string::npos) ++steps;
    }
    EXPECT_LE(number - steps, 501U);
  }
}

TEST_F(Recording, AFolderThatIsNotThereIsSaidAtOnce) {
  RunTape tape;
  try {
    const RunRecorder recorder(folder_ / "nowhere" / "run.mcap", tape, "");
    FAIL() << "a recording into a folder that does not exist";
  } catch (const StartupError& error) {
    EXPECT_THAT(error.what(), HasSubstr("No such file or directory"));
  }
}

TEST_F(Recording, IsNeverWrittenOver) {
  const auto file = folder_ / "run.mcap";
  EXPECT_EQ(unused_name(file), file);
  std::ofstream(file) << "x";
  EXPECT_EQ(unused_name(file), folder_ / "run-2.mcap");
  std::ofstream(folder_ / "run-2.mcap") << "x";
  EXPECT_EQ(unused_name(file), folder_ / "run-3.mcap");
}

TEST_F(Recording, TheControlThreadsSideAllocatesNothing) {
  RunTape tape(1, 16 * 1024);
  const std::size_t before = test::allocations;
  for (std::uint64_t number = 1; number < 100; ++number) step(tape, number);
  EXPECT_EQ(test::allocations, before);
  EXPECT_GT(tape.lost(), 0U) << "full, too";
}

}  // namespace
}  // namespace motionlab::record
