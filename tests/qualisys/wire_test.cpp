// Packets and their framing. Golden bytes marked "published" follow the vendor's protocol documentation; they
// are written out here and were not made by our encoder.
#include "drivers/qualisys/qualisys_wire.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "drivers/core/random.hpp"

namespace motionlab::qualisys {
namespace {

using testing::ElementsAreArray;

const ByteBuffer kPublishedVersion = {0x15, 0x00, 0x00, 0x00, 0x01, 0x00, 0x00, 0x00, 0x56, 0x65, 0x72,
                                      0x73, 0x69, 0x6f, 0x6e, 0x20, 0x31, 0x2e, 0x32, 0x35, 0x00};
const ByteBuffer kPublishedVersionAnswer = {0x1c, 0x00, 0x00, 0x00, 0x01, 0x00, 0x00, 0x00, 0x56, 0x65,
                                            0x72, 0x73, 0x69, 0x6f, 0x6e, 0x20, 0x73, 0x65, 0x74, 0x20,
                                            0x74, 0x6f, 0x20, 0x31, 0x2e, 0x32, 0x35, 0x00};
const ByteBuffer kPublishedConnected = {0x09, 0x00, 0x00, 0x00, 0x06, 0x00, 0x00, 0x00, 0x01};
const ByteBuffer kPublishedNoMoreData = {0x08, 0x00, 0x00, 0x00, 0x04, 0x00, 0x00, 0x00};

ByteBuffer welcome_bytes() {
  ByteBuffer bytes = {0x23, 0x00, 0x00, 0x00, 0x01, 0x00, 0x00, 0x00};
  for (const char c : std::string{"QTM RT Interface connected"})
    bytes.push_back(static_cast<std::uint8_t>(c));
  bytes.push_back(0);
  return bytes;
}

TEST(QualisysWire, WritesThePublishedSmallPackets) {
  EXPECT_EQ(encode_text(PacketType::command, "Version 1.25"), kPublishedVersion);
  EXPECT_EQ(encode_text(PacketType::command, "Version set to 1.25"), kPublishedVersionAnswer);
  EXPECT_EQ(encode_text(PacketType::command, kWelcome), welcome_bytes());
  EXPECT_EQ(encode_event(Event::connected), kPublishedConnected);
  EXPECT_EQ(encode_no_more_data(), kPublishedNoMoreData);
}

TEST(QualisysWire, ReadsThePublishedSmallPackets) {
  const auto version = decode_datagram(kPublishedVersion);
  ASSERT_TRUE(version);
  EXPECT_EQ(version->type, PacketType::command);
  EXPECT_EQ(packet_text(version->payload), "Version 1.25");
  EXPECT_EQ(packet_text(decode_datagram(kPublishedVersionAnswer)->payload), "Version set to 1.25");
  EXPECT_EQ(packet_text(decode_datagram(welcome_bytes())->payload), "QTM RT Interface connected");
  const auto event = decode_datagram(kPublishedConnected);
  ASSERT_TRUE(event);
  EXPECT_EQ(event->type, PacketType::event);
  EXPECT_EQ(decode_event(event->payload).value(), Event::connected);
  EXPECT_EQ(decode_datagram(kPublishedNoMoreData)->type, PacketType::no_more_data);
  EXPECT_TRUE(decode_datagram(kPublishedNoMoreData)->payload.empty());
}

TEST(QualisysWire, ReadsATextWhoseSenderLeftTheNulOut) {
  EXPECT_EQ(packet_text(as_bytes("getstate")), "getstate");
  EXPECT_EQ(packet_text(as_bytes(std::string_view{"getstate\0", 9})), "getstate");
  EXPECT_EQ(packet_text(as_bytes(std::string_view{"getstate\0\0x", 11})), "getstate");
  EXPECT_EQ(packet_text({}), "");
}

TEST(QualisysWire, RefusesADatagramThatIsNotExactlyOnePacket) {
  ByteBuffer shorter = kPublishedVersion;
  shorter.pop_back();
  EXPECT_EQ(decode_datagram(shorter).fault().reason, Reason::too_short);
  ByteBuffer longer = kPublishedVersion;
  longer.push_back(0);
  EXPECT_EQ(decode_datagram(longer).fault().reason, Reason::too_long);
  EXPECT_EQ(decode_datagram(Bytes{kPublishedVersion}.first(7)).fault().reason, Reason::too_short);
  EXPECT_EQ(decode_datagram({}).fault().reason, Reason::too_short);
  ByteBuffer tiny = kPublishedNoMoreData;
  tiny[0] = 7;
  EXPECT_EQ(decode_datagram(tiny).fault().reason, Reason::bad_header);
}

TEST(QualisysWire, RefusesAnEventThatIsNotOneByte) {
  const ByteBuffer two = {1, 2};
  EXPECT_EQ(decode_event({}).fault().reason, Reason::too_short);
  EXPECT_EQ(decode_event(two).fault().reason, Reason::too_long);
}

/// What a splitter makes of the bytes: type and text of each packet.
std::vector<std::string> drain(PacketSplitter& splitter) {
  std::vector<std::string> packets;
  while (const auto packet = splitter.next()) {
    if (!*packet) {
      packets.push_back("fault " + std::string{to_string(packet->fault().reason)});
      break;
    }
    packets.push_back(std::to_string(static_cast<unsigned>((*packet)->type)) + ":" +
                      std::string{packet_text((*packet)->payload)});
  }
  return packets;
}

ByteBuffer conversation() {
  ByteBuffer bytes = welcome_bytes();
  for (const auto* packet : {&kPublishedVersionAnswer, &kPublishedConnected, &kPublishedNoMoreData})
    bytes.insert(bytes.end(), packet->begin(), packet->end());
  return bytes;
}
const std::vector<std::string> kConversation = {"1:QTM RT Interface connected", "1:Version set to 1.25",
                                                "6:\x01", "4:"};

TEST(QualisysSplitter, FindsThePacketsWhereverTheStreamIsCut) {
  const ByteBuffer bytes = conversation();
  for (std::size_t cut = 0; cut <= bytes.size(); ++cut) {
    PacketSplitter splitter;
    splitter.push(Bytes{bytes}.first(cut));
    std::vector<std::string> packets = drain(splitter);
    splitter.push(Bytes{bytes}.subspan(cut));
    for (auto& packet : drain(splitter)) packets.push_back(packet);
    ASSERT_THAT(packets, ElementsAreArray(kConversation)) << "cut at " << cut;
    EXPECT_FALSE(splitter.in_packet());
  }
}

TEST(QualisysSplitter, FindsThePacketsInAStreamOfSingleBytes) {
  PacketSplitter splitter;
  std::vector<std::string> packets;
  for (const std::uint8_t byte : conversation()) {
    splitter.push({&byte, 1});
    for (auto& packet : drain(splitter)) packets.push_back(packet);
  }
  EXPECT_THAT(packets, ElementsAreArray(kConversation));
}

TEST(QualisysSplitter, KnowsThatItIsInsideAPacket) {
  PacketSplitter splitter;
  EXPECT_FALSE(splitter.in_packet());
  splitter.push(Bytes{kPublishedVersion}.first(3));
  EXPECT_FALSE(splitter.next());
  EXPECT_TRUE(splitter.in_packet());
  splitter.reset();
  EXPECT_FALSE(splitter.in_packet());
}

TEST(QualisysSplitter, ReportsASizeThatCannotBeAsSoonAsItIsReadAndUntilReset) {
  const ByteBuffer below = {7, 0, 0, 0};
  const ByteBuffer above = {0x01, 0x01, 0, 0};
  PacketSplitter splitter{256};
  splitter.push(below);
  EXPECT_EQ(splitter.next()->fault().reason, Reason::bad_header);
  splitter.push(kPublishedVersion);
  EXPECT_EQ(splitter.next()->fault().reason, Reason::bad_header);
  splitter.reset();
  splitter.push(above);
  EXPECT_EQ(splitter.next()->fault().reason, Reason::too_long);
  splitter.reset();
  splitter.push(kPublishedVersion);
  EXPECT_TRUE(splitter.next()->ok());
}

TEST(QualisysSplitter, SurvivesRandomBytes) {
  Random random{7};
  for (int round = 0; round < 2000; ++round) {
    PacketSplitter splitter{512};
    for (int piece = 0; piece < 20; ++piece) {
      ByteBuffer bytes(random.below(40));
      for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random.below(4) == 0 ? random.bits() : 0);
      splitter.push(bytes);
      while (const auto packet = splitter.next())
        if (!*packet) {
          splitter.reset();
          break;
        }
    }
  }
}

}  // namespace
}  // namespace motionlab::qualisys
