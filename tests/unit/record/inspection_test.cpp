// What is in a file, what is missing, and that a repaired one is whole.
#include "gateway/record/inspection.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <set>
#include <sstream>
#include <string>

#include "gateway/record/mcap_writer.hpp"

namespace motionlab::record {
namespace {

using testing::HasSubstr;
using testing::Pair;
using testing::UnorderedElementsAre;

/// Two topics in many small chunks; the texts are of the length that lets a test find them.
std::string sample_file(bool finished = true, int messages = 100) {
  std::ostringstream out;
  McapWriter writer(out, {.profile = {}, .library = "a test", .zstd_level = 0, .chunk_bytes = 200});
  writer.metadata("motionlab/recording", {{"part", "1"}});
  writer.attachment("lab.toml", "application/toml", LabTime{5ns}, as_bytes("[control]"));
  const SchemaId schema = writer.add_schema("motionlab::Text", "omgidl", "struct Text {};");
  const ChannelId often = writer.add_channel("often", "cdr", schema);
  const ChannelId seldom = writer.add_channel("seldom", "cdr", 0);
  for (int i = 0; i < messages; ++i) {
    const std::string text = "message " + std::to_string(1000 + i);
    writer.message(i % 10 == 0 ? seldom : often, static_cast<std::uint32_t>(i), LabTime{10ms * (i + 1)},
                   LabTime{10ms * i}, as_bytes(text));
  }
  if (finished) {
    writer.finish();
  } else {
    writer.end_chunk();
  }
  return out.str();
}

Inspection inspected(const std::string& bytes) {
  std::istringstream in(bytes);
  return inspect(in);
}

std::set<std::string> texts_in(const std::string& bytes) {
  std::istringstream in(bytes);
  McapReader reader(in);
  std::set<std::string> texts;
  for (auto item = reader.next(); item && item->has_value(); item = reader.next()) {
    if (const auto* message = std::get_if<McapMessage>(&**item)) texts.emplace(as_text(message->data));
  }
  return texts;
}

/// The repaired file; it must be whole, whatever it was made of.
std::string repaired(const std::string& bytes, std::uint64_t& damages) {
  std::istringstream in(bytes);
  std::ostringstream out;
  damages = repair(in, out).damage_count;
  const Inspection after = inspected(out.str());
  EXPECT_TRUE(after.whole());
  EXPECT_EQ(after.messages(), texts_in(out.str()).size());
  return out.str();
}

TEST(Inspection, TellsWhatIsInAWholeFile) {
  const Inspection seen = inspected(sample_file());
  EXPECT_TRUE(seen.whole());
  EXPECT_EQ(seen.library, "a test");
  EXPECT_EQ(seen.messages(), 100U);
  ASSERT_EQ(seen.topics.size(), 2U);
  EXPECT_EQ(seen.topics[0].topic, "seldom");
  EXPECT_EQ(seen.topics[0].type, "");
  EXPECT_EQ(seen.topics[1].type, "motionlab::Text");
  EXPECT_EQ(seen.topics[1].messages, 90U);
  EXPECT_EQ(seen.topics[1].first_ns, 20'000'000U);
  EXPECT_EQ(seen.topics[1].last_ns, 1'000'000'000U);
  EXPECT_EQ(seen.topics[1].numbers.missing(), 9U) << "the numbers of the other topic are missing in this one";
  EXPECT_THAT(seen.attachments, UnorderedElementsAre(Pair("lab.toml", 9U)));
  ASSERT_EQ(seen.metadata.size(), 1U);
  EXPECT_EQ(seen.metadata[0].values.at("part"), "1");
}

TEST(Inspection, MissesTheEndOfAFileWhoseWriterDied) {
  const Inspection seen = inspected(sample_file(false));
  EXPECT_FALSE(seen.whole());
  EXPECT_FALSE(seen.complete);
  EXPECT_EQ(seen.damage_count, 0U);
  EXPECT_EQ(seen.messages(), 100U);
}

TEST(Inspection, FindsADamagedChunkAndReadsTheOthers) {
  std::string bytes = sample_file();
  bytes[bytes.find("message 1050")] = 'M';
  const Inspection seen = inspected(bytes);
  EXPECT_FALSE(seen.whole());
  EXPECT_EQ(seen.damage_count, 2U) << "the chunk's checksum and the whole file's";
  EXPECT_THAT(std::string(seen.damages.at(0).text), HasSubstr("checksum"));
  EXPECT_TRUE(seen.complete);
  EXPECT_GT(seen.messages(), 90U);
  EXPECT_LT(seen.messages(), 100U);
}

TEST(Inspection, FindsADamagedIndex) {
  std::string bytes = sample_file();
  const std::size_t in_summary = bytes.rfind("seldom");
  bytes[in_summary] = 'S';
  const Inspection seen = inspected(bytes);
  EXPECT_FALSE(seen.whole());
  EXPECT_EQ(seen.messages(), 100U);
  ASSERT_EQ(seen.damage_count, 1U);
  EXPECT_THAT(std::string(seen.damages[0].text), HasSubstr("summary"));
}

TEST(Inspection, RefusesWhatIsNoRecording) {
  for (const char* const bytes : {"", "MCAP", "not a recording, but longer than its magic"}) {
    const Inspection seen = inspected(bytes);
    EXPECT_FALSE(seen.whole());
    ASSERT_EQ(seen.damage_count, 1U) << bytes;
    EXPECT_THAT(std::string(seen.damages[0].text), HasSubstr("not an MCAP file"));
  }
}

TEST(Repair, GivesAFileOfADeadWriterItsEnd) {
  const std::string whole = sample_file();
  const std::string dead = sample_file(false);
  std::uint64_t damages = 0;
  EXPECT_EQ(texts_in(repaired(dead, damages)), texts_in(whole));
  EXPECT_EQ(damages, 0U);
  for (std::size_t size = kMcapMagic.size(); size < dead.size(); size += 7) {
    const std::string cut = repaired(dead.substr(0, size), damages);
    EXPECT_EQ(texts_in(cut), texts_in(dead.substr(0, size))) << size;
  }
}

TEST(Repair, KeepsAttachmentsMetadataSchemasAndTimes) {
  std::uint64_t damages = 0;
  const std::string bytes = repaired(sample_file(false), damages);
  const Inspection seen = inspected(bytes);
  EXPECT_THAT(seen.attachments, UnorderedElementsAre(Pair("lab.toml", 9U)));
  EXPECT_EQ(seen.metadata.at(0).name, "motionlab/recording");
  EXPECT_EQ(seen.metadata.at(1).name, kRepairMetadata);
  EXPECT_EQ(seen.metadata.at(1).values.at("complete"), "false");
  EXPECT_EQ(seen.topics.at(1).type, "motionlab::Text");
  EXPECT_EQ(seen.topics.at(1).last_ns, 1'000'000'000U);
  std::istringstream in(bytes);
  McapReader reader(in);
  while (reader.next().value().has_value()) continue;
  EXPECT_EQ(reader.channels().at(1).schema, nullptr);
  EXPECT_EQ(reader.channels().at(2).schema->text, "struct Text {};");
}

TEST(Repair, MakesAWholeFileOfWhateverItIsGiven) {
  const std::string good = sample_file();
  const std::set<std::string> all = texts_in(good);
  std::size_t saved = 0;
  for (std::size_t at = kMcapMagic.size(); at < good.size(); ++at) {
    std::string bad = good;
    bad[at] = static_cast<char>(bad[at] ^ 0x41);
    std::uint64_t damages = 0;
    const std::set<std::string> texts = texts_in(repaired(bad, damages));
    saved += texts.size();
  }
  EXPECT_GT(saved, (good.size() - kMcapMagic.size()) * all.size() / 2)
      << "one wrong byte costs one chunk, seldom more";
}

}  // namespace
}  // namespace motionlab::record
