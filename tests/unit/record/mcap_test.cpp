// MCAP files: what is written is read, and nothing that is read is trusted.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>
#include <string>
#include <vector>

#include "gateway/record/crc32.hpp"
#include "gateway/record/mcap_reader.hpp"
#include "gateway/record/mcap_writer.hpp"

namespace motionlab::record {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

/// A file with two channels, some metadata and an attachment.
std::string sample_file(McapWriterOptions options = {}, int messages = 20, bool finished = true) {
  std::ostringstream out;
  McapWriter writer(out, std::move(options));
  writer.metadata("made", {{"by", "a test"}, {"for", "the reader"}});
  writer.attachment("notes.txt", "text/plain", LabTime{5ns}, as_bytes("to be kept"));
  const SchemaId schema = writer.add_schema("motionlab::Text", "omgidl", "struct Text {};");
  const ChannelId first = writer.add_channel("first", "cdr", schema, {{"key", "value"}});
  const ChannelId second = writer.add_channel("second", "cdr", 0);
  for (int i = 0; i < messages; ++i) {
    const std::string text = "message " + std::to_string(i);
    writer.message(i % 3 == 0 ? second : first, static_cast<std::uint32_t>(i), LabTime{1us * i},
                   LabTime{1us * i - 1ns}, as_bytes(text));
  }
  if (finished) {
    writer.finish();
  } else {
    writer.end_chunk();
  }
  EXPECT_TRUE(writer.ok());
  EXPECT_EQ(writer.bytes_written(), out.str().size());
  return out.str();
}

struct Contents {
  std::vector<std::string> items;
  std::string fault;
  bool complete = false;
};

Contents read(const std::string& bytes) {
  std::istringstream in(bytes);
  McapReader reader(in);
  Contents contents;
  for (;;) {
    const auto item = reader.next();
    if (!item) {
      contents.fault = item.fault().text;
      EXPECT_EQ(std::string(reader.next().fault().text), contents.fault) << "a fault stays";
      return contents;
    }
    if (!item->has_value()) break;
    if (const auto* message = std::get_if<McapMessage>(&**item)) {
      contents.items.push_back(message->channel->topic + ' ' + std::to_string(message->sequence) + ' ' +
                               std::to_string(message->logged_ns) + ' ' +
                               std::to_string(message->published_ns) + ' ' +
                               std::string(as_text(message->data)));
    } else if (const auto* attachment = std::get_if<McapAttachment>(&**item)) {
      contents.items.push_back(attachment->name + ' ' + attachment->media_type + ' ' +
                               std::string(as_text(attachment->data)));
    } else {
      const auto& metadata = std::get<McapMetadata>(**item);
      const auto by = metadata.values.find("by");  // a flipped bit may have renamed it
      contents.items.push_back(metadata.name + ' ' + (by == metadata.values.end() ? "" : by->second));
    }
  }
  contents.complete = reader.complete();
  EXPECT_FALSE(reader.next().value().has_value()) << "the end stays the end";
  return contents;
}

TEST(Mcap, WhatIsWrittenIsRead) {
  for (const int level : {0, 3, 19}) {
    for (const std::size_t chunk : {std::size_t{1}, std::size_t{200}, std::size_t{1} << 20}) {
      const auto contents =
          read(sample_file({.profile = "", .library = "test", .zstd_level = level, .chunk_bytes = chunk}));
      EXPECT_EQ(contents.fault, "");
      EXPECT_TRUE(contents.complete);
      ASSERT_EQ(contents.items.size(), 22U);
      EXPECT_EQ(contents.items[0], "made a test");
      EXPECT_EQ(contents.items[1], "notes.txt text/plain to be kept");
      EXPECT_EQ(contents.items[3], "first 1 1000 999 message 1");
      EXPECT_EQ(contents.items[21], "first 19 19000 18999 message 19");
    }
  }
}

TEST(Mcap, ChannelsComeWithTheirSchema) {
  std::istringstream in(sample_file());
  McapReader reader(in);
  while (reader.next().value().has_value()) continue;
  ASSERT_EQ(reader.channels().size(), 2U);
  const McapChannel& first = reader.channels().at(1);
  ASSERT_NE(first.schema, nullptr);
  EXPECT_EQ(first.schema->name, "motionlab::Text");
  EXPECT_EQ(first.schema->text, "struct Text {};");
  EXPECT_EQ(first.metadata.at("key"), "value");
  EXPECT_EQ(reader.channels().at(2).schema, nullptr);
  EXPECT_EQ(reader.library(), "motionlab");
}

TEST(Mcap, TheSameMessagesAreTheSameBytes) {
  EXPECT_EQ(sample_file(), sample_file());
}

TEST(Mcap, AFileOfADeadWriterIsReadUpToItsLastWholeRecord) {
  const McapWriterOptions small{.profile = "", .library = "", .zstd_level = 3, .chunk_bytes = 100};
  const std::string whole = sample_file(small, 20, false);
  const auto all = read(whole).items;
  ASSERT_EQ(all.size(), 22U);
  std::size_t longest = 0;
  for (std::size_t size = kMcapMagic.size(); size <= whole.size(); ++size) {
    const auto contents = read(whole.substr(0, size));
    EXPECT_EQ(contents.fault, "") << size;
    EXPECT_FALSE(contents.complete) << size;
    ASSERT_LE(contents.items.size(), all.size());
    EXPECT_TRUE(std::equal(contents.items.begin(), contents.items.end(), all.begin())) << size;
    EXPECT_GE(contents.items.size(), longest) << "more bytes, fewer messages";
    longest = contents.items.size();
  }
  EXPECT_EQ(longest, 22U);
}

TEST(Mcap, AFlippedBitInTheDataIsSeen) {
  const std::string good = sample_file();
  const std::size_t data_end = good.find("motionlab::Text", good.find("motionlab::Text") + 1);
  ASSERT_NE(data_end, std::string::npos);
  // Lengths apart, which can look like a file that was cut off, each bit is under some checksum.
  std::size_t unseen = 0, tried = 0;
  for (std::size_t at = kMcapMagic.size(); at < data_end - 40; ++at) {
    std::string bad = good;
    bad[at] = static_cast<char>(bad[at] ^ 0x10);
    const auto contents = read(bad);
    ++tried;
    if (contents.fault.empty() && contents.complete) ++unseen;
  }
  EXPECT_GT(tried, 300U);
  EXPECT_EQ(unseen, 0U);
}

TEST(Mcap, WhatIsNoMcapFileIsRefused) {
  EXPECT_THAT(read("").fault, HasSubstr("not an MCAP file"));
  EXPECT_THAT(read("t,x,y\n0,1,2\n").fault, HasSubstr("not an MCAP file"));
}

/// A file made of the given records.
std::string file_of(const std::vector<std::pair<Opcode, std::string>>& records) {
  std::string bytes(kMcapMagic.begin(), kMcapMagic.end());
  for (const auto& [opcode, content] : records) {
    RecordBuilder record;
    record.begin(opcode);
    record.put_bytes(as_bytes(content));
    record.end();
    bytes += as_text(record.bytes());
  }
  return bytes;
}

std::string chunk_of(std::uint64_t size, std::string_view compression, std::string_view content) {
  RecordBuilder record;
  record.put(std::uint64_t{0});
  record.put(std::uint64_t{0});
  record.put(size);
  record.put(std::uint32_t{0});
  record.put_text(compression);
  record.put(static_cast<std::uint64_t>(content.size()));
  record.put_bytes(as_bytes(content));
  return std::string(as_text(record.bytes()));
}

TEST(Mcap, LiesAboutSizesAreRefused) {
  EXPECT_THAT(read(file_of({{Opcode::chunk, chunk_of(1ULL << 40, "zstd", "x")}})).fault,
              HasSubstr("larger than 64 MiB"));
  EXPECT_THAT(read(file_of({{Opcode::chunk, chunk_of(1000, "zstd", "not zstd")}})).fault,
              HasSubstr("cannot be unpacked"));
  EXPECT_THAT(read(file_of({{Opcode::chunk, chunk_of(2, "", "x")}})).fault, HasSubstr("shorter"));
  EXPECT_THAT(read(file_of({{Opcode::chunk, chunk_of(1, "lz4", "x")}})).fault, HasSubstr("something else"));
  EXPECT_THAT(read(file_of({{Opcode::message, std::string(30, '\1')}})).fault,
              HasSubstr("before its channel"));
  EXPECT_THAT(read(file_of({{Opcode::schema, std::string("\1\0\xff\xff\xff\xff", 6)}})).fault,
              HasSubstr("shorter"));
  // A length beyond the file's end cannot be told from a file that was cut off.
  std::string endless = file_of({{Opcode::metadata, "x"}});
  endless[kMcapMagic.size() + 8] = '\x7f';
  EXPECT_EQ(read(endless).fault, "");
  EXPECT_FALSE(read(endless).complete);
}

TEST(Mcap, UnknownRecordsAreReadOver) {
  const auto contents = read(file_of({{static_cast<Opcode>(0x7f), "from the future"}}));
  EXPECT_EQ(contents.fault, "");
  EXPECT_TRUE(contents.items.empty());
}

/// A stream whose disk is full after some bytes.
class FullDisk : public std::streambuf {
 public:
  explicit FullDisk(std::streamsize room) : room_(room) {}

 private:
  std::streamsize xsputn(const char*, std::streamsize size) override {
    const std::streamsize taken = std::min(size, room_);
    room_ -= taken;
    return taken;
  }
  int_type overflow(int_type) override { return traits_type::eof(); }
  std::streamsize room_;
};

TEST(Mcap, AFullDiskIsSaidAndNothingIsWrittenAfterIt) {
  FullDisk disk(400);
  std::ostream out(&disk);
  McapWriter writer(out, {.profile = "", .library = "", .zstd_level = 0, .chunk_bytes = 100});
  const ChannelId channel = writer.add_channel("topic", "cdr", 0);
  for (std::uint32_t i = 0; i < 100; ++i)
    writer.message(channel, i, LabTime{}, LabTime{}, as_bytes("0123456789"));
  EXPECT_FALSE(writer.ok());
  writer.finish();
  EXPECT_FALSE(writer.ok());
}

TEST(Crc32, IsTheOneThatEverybodyHas) {
  EXPECT_EQ(crc32(as_bytes("123456789")), 0xCBF43926U);  // the check value of the catalogue of CRCs
  EXPECT_EQ(crc32({}), 0U);
  EXPECT_EQ(crc32(as_bytes("456789"), crc32(as_bytes("123"))), 0xCBF43926U);
}

}  // namespace
}  // namespace motionlab::record
