// A recording in the order of its time.
#include "gateway/record/ordered_messages.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "gateway/record/mcap_writer.hpp"

namespace motionlab::record {
namespace {

using testing::ElementsAre;

std::string file_of(const std::vector<std::pair<Nanoseconds, std::string>>& messages) {
  std::ostringstream out;
  McapWriter writer(out, {.profile = {}, .library = {}, .zstd_level = 0, .chunk_bytes = 64});
  const ChannelId channel = writer.add_channel("topic", "cdr", 0);
  for (const auto& [t, text] : messages) writer.message(channel, 0, LabTime{t}, LabTime{t}, as_bytes(text));
  writer.finish();
  return out.str();
}

std::vector<std::string> in_order(const std::string& bytes, std::string* fault = nullptr) {
  std::istringstream in(bytes);
  McapReader reader(in);
  OrderedMessages ordered(reader);
  std::vector<std::string> texts;
  while (const auto message = ordered.next()) {
    EXPECT_EQ(message->channel->topic, "topic");
    texts.emplace_back(as_text(message->data));
  }
  if (fault && ordered.fault()) *fault = ordered.fault()->text;
  return texts;
}

TEST(OrderedMessages, GivesWhatLiesOutOfOrderInTheOrderOfItsTime) {
  EXPECT_THAT(in_order(file_of({{30ms, "c"}, {10ms, "a"}, {20ms, "b"}, {1500ms, "e"}, {900ms, "d"}})),
              ElementsAre("a", "b", "c", "d", "e"));
}

TEST(OrderedMessages, KeepsEqualTimesAsTheyLie) {
  EXPECT_THAT(in_order(file_of({{1s, "x"}, {1s, "y"}, {1s, "z"}})), ElementsAre("x", "y", "z"));
}

TEST(OrderedMessages, LooksNoFurtherAheadThanItSays) {
  EXPECT_THAT(in_order(file_of({{5s, "late"}, {10s, "later"}, {1s, "far too early"}})),
              ElementsAre("late", "far too early", "later"));
}

TEST(OrderedMessages, LeavesOutWhatIsDamagedAndSaysSo) {
  std::string bytes = file_of({{1s, "first, long enough for a chunk of its own, or nearly"},
                               {2s, "second, long enough for a chunk of its own, or nearly"},
                               {3s, "third, long enough for a chunk of its own, or nearly so"}});
  bytes[bytes.find("second")] = 'S';
  std::string fault;
  const auto texts = in_order(bytes, &fault);
  ASSERT_EQ(texts.size(), 2U);
  EXPECT_EQ(texts[1].substr(0, 5), "third");
  EXPECT_NE(fault, "");
}

}  // namespace
}  // namespace motionlab::record
