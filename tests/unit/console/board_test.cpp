#include "gateway/console/board.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <set>
#include <string>
#include <vector>

namespace motionlab::console {
namespace {

constexpr std::size_t kHealth = bus::topic_index<topic::Health>();
constexpr std::size_t kEvent = bus::topic_index<topic::Event>();
constexpr std::size_t kMru = bus::topic_index<topic::Mru>();
constexpr auto channel(std::size_t topic) {
  return static_cast<std::uint32_t>(topic) + 1;
}

Payload bytes() {
  return std::make_shared<const std::vector<std::byte>>(4);
}

class TheBoard : public testing::Test {
 protected:
  /// One look round at `t` when exactly these topics have writers.
  Board::Change look(Nanoseconds t, const std::set<std::size_t>& written) {
    std::vector<bool> all;
    for (std::size_t topic = 0; topic < bus::kTopicList.size(); ++topic)
      all.push_back(written.contains(topic));
    return board_.look(LabTime{t}, all);
  }
  Board board_;
};

TEST_F(TheBoard, HasTheConsolesOwnChannelFromTheBeginning) {
  EXPECT_EQ(board_.channels(), std::vector<std::uint32_t>{kOwnChannel});
  EXPECT_TRUE(board_.open(kOwnChannel));
  for (const std::uint32_t none : {0U, kOwnChannel + 1, channel(kMru)}) EXPECT_FALSE(board_.open(none));
}

TEST_F(TheBoard, OpensAChannelWithItsFirstWriter) {
  EXPECT_EQ(look(1s, {kMru}).come, std::vector<std::uint32_t>{channel(kMru)});
  EXPECT_TRUE(look(2s, {kMru}).come.empty());
  EXPECT_TRUE(board_.open(channel(kMru)));
}

TEST_F(TheBoard, KeepsAChannelThroughARestartAndClosesItWhenNobodyComesBack) {
  look(1s, {kMru});
  EXPECT_TRUE(look(10s, {}).gone.empty());
  EXPECT_TRUE(look(10500ms, {kMru}).come.empty());
  EXPECT_TRUE(look(20s, {}).gone.empty());
  EXPECT_EQ(look(20500ms, {}).gone, std::vector<std::uint32_t>{channel(kMru)});
  EXPECT_FALSE(board_.open(channel(kMru)));
}

TEST_F(TheBoard, RemembersTheNewestStateOfEveryInstance) {
  look(1s, {kHealth});
  for (int round = 0; round < 5; ++round) {
    for (const char* device : {"mru1", "arm"}) board_.accept(kHealth, device, LabTime{round * 1s}, bytes());
  }
  const auto remembered = board_.remembered(channel(kHealth));
  ASSERT_EQ(remembered.size(), 2U);
  EXPECT_NE(remembered[0].slot, remembered[1].slot);
  for (const Parcel& parcel : remembered) EXPECT_EQ(parcel.t_ns, 4'000'000'000);
}

TEST_F(TheBoard, RemembersTheLastHundredEventsInOrderAndNoSensor) {
  look(1s, {kEvent, kMru});
  for (int i = 0; i < 150; ++i) board_.accept(kEvent, "", LabTime{Nanoseconds{i}}, bytes());
  board_.accept(kMru, "mru1", LabTime{}, bytes());
  const auto events = board_.remembered(channel(kEvent));
  ASSERT_EQ(events.size(), 100U);
  EXPECT_EQ(events.front().t_ns, 50);
  EXPECT_EQ(events.back().t_ns, 149);
  EXPECT_TRUE(events.front().every_counts);
  EXPECT_TRUE(board_.remembered(channel(kMru)).empty());
}

TEST_F(TheBoard, IsBoundedWhenAStrangerNamesManyInstances) {
  look(1s, {kHealth});
  std::set<std::uint32_t> slots;
  for (int i = 0; i < 100'000; ++i) {
    slots.insert(board_.accept(kHealth, "device " + std::to_string(i), LabTime{}, bytes()).slot);
  }
  EXPECT_EQ(slots.size(), 129U);
  EXPECT_EQ(board_.remembered(channel(kHealth)).size(), 129U);
}

TEST_F(TheBoard, GivesNoTwoTopicsOneSlot) {
  std::set<std::uint32_t> slots;
  for (std::size_t topic = 0; topic < bus::kTopicList.size(); ++topic) {
    for (int i = 0; i < 500; ++i)
      slots.insert(board_.accept(topic, std::to_string(i), LabTime{}, bytes()).slot);
  }
  EXPECT_EQ(slots.size(), 129U * bus::kTopicList.size());
}

}  // namespace
}  // namespace motionlab::console
