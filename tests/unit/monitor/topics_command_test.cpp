#include "gateway/monitor/topics_command.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace motionlab::monitor {
namespace {

using testing::ContainsRegex;
using testing::HasSubstr;
using testing::Not;

bus::SeenEndpoint end(const char* topic, const char* type, bool writes, const char* participant) {
  bus::SeenEndpoint seen;
  seen.topic = topic;
  seen.type = type;
  seen.writes = writes;
  seen.participant = participant;
  seen.host = "labhost";
  seen.process = "4711";
  return seen;
}

TEST(Topics, AreOneRowForEachNameAndType) {
  const auto rows =
      rows_of({end("motionlab/mru", "motionlab::Mru", true, "gateway"),
               end("motionlab/mru", "motionlab::Mru", false, "alice"),
               end("motionlab/mru", "other::Mru", false, "bob"), end("a/first", "other::A", true, "bob")});
  ASSERT_EQ(rows.size(), 3u);
  EXPECT_EQ(rows[0].name, "a/first");
  EXPECT_FALSE(rows[0].known);
  EXPECT_EQ(rows[1].type, "motionlab::Mru");
  EXPECT_TRUE(rows[1].known);
  EXPECT_EQ(rows[1].writers.size(), 1u);
  EXPECT_EQ(rows[1].readers.size(), 1u);
  EXPECT_EQ(rows[2].type, "other::Mru");
}

TEST(TopicsText, SaysWhoWritesAndWithWhichQuality) {
  bus::SeenEndpoint writer = end("truth/world", "motionlab::TruthWorld", true, "sim");
  writer.qos.reliable = true;
  writer.qos.durability = bus::Durability::transient_local;
  writer.qos.partitions = {"truth"};
  const std::string text = topics_text(rows_of({writer, end("other/x", "other::X", false, "")}), false);
  EXPECT_THAT(text, HasSubstr("truth/world  motionlab::TruthWorld   "));
  EXPECT_THAT(text, HasSubstr("  reliable transient_local partition truth  sim on labhost\n"));
  EXPECT_THAT(text, ContainsRegex("other/x +other::X \\(unknown type\\) +0 +1 +best_effort volatile +read by "
                                  "somebody without a name on labhost\n"));
  EXPECT_THAT(text, Not(HasSubstr("4711")));
}

TEST(TopicsText, ShowsEachEndpointWhenAsked) {
  bus::SeenEndpoint reader = end("motionlab/mru", "motionlab::Mru", false, "alice");
  reader.qos.reliable = true;
  const std::string text =
      topics_text(rows_of({end("motionlab/mru", "motionlab::Mru", true, "gateway"), reader}), true);
  EXPECT_THAT(text, ContainsRegex("  writes +best_effort volatile +gateway on labhost, process 4711\n"));
  EXPECT_THAT(text, ContainsRegex("  reads +reliable volatile +alice on labhost, process 4711\n"));
}

TEST(TopicsText, SaysMixedWhenWritersOfferDifferentThings) {
  bus::SeenEndpoint reliable = end("motionlab/mru", "motionlab::Mru", true, "a");
  reliable.qos.reliable = true;
  const std::string text =
      topics_text(rows_of({reliable, end("motionlab/mru", "motionlab::Mru", true, "b")}), false);
  EXPECT_THAT(text, HasSubstr("mixed"));
  EXPECT_THAT(text, HasSubstr("a on labhost, b on labhost"));
}

TEST(TopicsText, LetsNoStrangerWriteToTheTerminal) {
  bus::SeenEndpoint evil = end("\033[2J", "ty\npe", true, "\033]0;title\a");
  evil.host = "\x9b";
  evil.process = "\r";
  evil.qos.partitions = {"\033[31m"};
  const std::string text = topics_text(rows_of({evil}), true);
  for (const char character : text) EXPECT_TRUE(character == '\n' || (character >= 0x20 && character < 0x7F));
  EXPECT_THAT(text, HasSubstr("ty\\npe"));
}

TEST(TopicsJson, TellsEverythingThatIsKnown) {
  bus::SeenEndpoint writer = end("motionlab/mru", "motionlab::Mru", true, "gateway");
  writer.qos.deadline_s = 0.015;
  const auto json =
      topics_json(rows_of({writer}), {{.id = {}, .name = "gateway", .host = "h", .process = "1"}});
  EXPECT_EQ(json["participants"][0]["name"], "gateway");
  const auto& topic = json["topics"][0];
  EXPECT_EQ(topic["topic"], "motionlab/mru");
  EXPECT_EQ(topic["known"], true);
  EXPECT_EQ(topic["readers"].size(), 0u);
  EXPECT_EQ(topic["writers"][0]["reliability"], "best_effort");
  EXPECT_EQ(topic["writers"][0]["durability"], "volatile");
  EXPECT_EQ(topic["writers"][0]["deadline_s"], 0.015);
  EXPECT_EQ(topic["writers"][0]["process"], "4711");
}

}  // namespace
}  // namespace motionlab::monitor
