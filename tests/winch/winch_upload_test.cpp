// What a PLC tells of all its symbols and types, and the laboratory's own symbols. Golden bytes are
// constructed by hand from the layout that Beckhoff's AdsDef.h gives.
#include <gtest/gtest.h>

#include <limits>
#include <vector>

#include "drivers/winch/winch_wire.hpp"

namespace motionlab::winch {
namespace {

using V = std::vector<std::uint8_t>;

template <class Message>
V encoded(const Message& message) {
  V buffer(4096);
  LittleWriter writer{buffer};
  message.encode(writer);
  EXPECT_TRUE(writer.ok());
  buffer.resize(writer.position());
  return buffer;
}

// Constructed: a struct S of 4 bytes with one UDINT n.
const V kMember = {
    0x36, 0, 0,   0,   1,   0,   0,   0, 0,    0,    0,    0,
    0,    0, 0,   0,  // length 54, version, hashes
    4,    0, 0,   0,   0,   0,   0,   0, 0x13, 0,    0,    0,
    2,    0, 0,   0,                                              // size 4, offset 0, UDINT, data item
    1,    0, 5,   0,   0,   0,   0,   0, 0,    0,                 // lengths, no array, no members
    'n',  0, 'U', 'D', 'I', 'N', 'T', 0, 0,    0xAA, 0xBB, 0xCC,  // texts; then what newer entries have
};
V struct_with_member() {
  V bytes = {
      0x64, 0, 0, 0, 1, 0, 0, 0, 0,    0, 0, 0, 0, 0, 0, 0,  // length 100
      4,    0, 0, 0, 0, 0, 0, 0, 0x41, 0, 0, 0, 1, 0, 0, 0,  // a struct, data type
      1,    0, 0, 0, 0, 0, 0, 0, 1,    0,                    // one member
      'S',  0, 0, 0,
  };
  for (const auto byte : kMember) bytes.push_back(byte);
  return bytes;
}

TEST(WinchUpload, DecodesAConstructedStructAndItsMember) {
  V bytes = struct_with_member();
  bytes[0] = static_cast<std::uint8_t>(bytes.size());
  const auto type = DataTypeEntry::decode(bytes);
  ASSERT_TRUE(type.ok()) << type.fault().text;
  EXPECT_EQ(type->name, "S");
  EXPECT_EQ(type->size, 4U);
  EXPECT_EQ(type->data_type, DataType::structure);
  ASSERT_EQ(type->members, 1U);
  EntryReader members{type->member_entries};
  const auto member = DataTypeEntry::decode(**members.next());
  ASSERT_TRUE(member.ok());
  EXPECT_EQ(member->name, "n");
  EXPECT_EQ(member->type, "UDINT");
  EXPECT_EQ(member->data_type, DataType::udint);
  EXPECT_FALSE(members.next()->has_value());
}

TEST(WinchUpload, EncodesTheSameStructButForWhatNewerEntriesHave) {
  V buffer(256);
  LittleWriter writer{buffer};
  const std::vector<DataTypeEntry> members = {{4, 0, DataType::udint, 2, "n", "UDINT", {}, 0, 0, {}}};
  DataTypeEntry{4, 0, DataType::structure, 1, "S", {}, {}, 0, 0, {}}.encode(writer, members);
  buffer.resize(writer.position());
  V wanted = struct_with_member();
  wanted.resize(wanted.size() - 3);
  wanted[0] = static_cast<std::uint8_t>(wanted.size());
  wanted[46] = static_cast<std::uint8_t>(kMember.size() - 3);
  EXPECT_EQ(buffer, wanted);
}

TEST(WinchUpload, RefusesEveryPrefixOfAStruct) {
  V bytes = struct_with_member();
  bytes[0] = static_cast<std::uint8_t>(bytes.size());
  for (std::size_t n = 0; n < bytes.size(); ++n) {
    EXPECT_FALSE(DataTypeEntry::decode(Bytes{bytes}.first(n)).ok()) << n;
  }
  bytes[40] = 2;  // says two members
  EXPECT_FALSE(DataTypeEntry::decode(bytes).ok());
  bytes[40] = 1;
  bytes[38] = 2;  // two dimensions
  EXPECT_EQ(DataTypeEntry::decode(bytes).fault().reason, Reason::bad_value);
}

TEST(WinchUpload, KnowsTheInfoInItsThreeSizes) {
  const UploadInfo info{5, 300, 3, 200, 0, 0};
  V bytes = encoded(info);
  EXPECT_EQ(bytes, (V{5, 0, 0, 0, 0x2C, 1, 0, 0, 3, 0, 0, 0, 200, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}));
  EXPECT_EQ(*UploadInfo::decode(bytes), info);
  EXPECT_EQ(UploadInfo::decode(Bytes{bytes}.first(8))->symbol_bytes, 300U);
  bytes.resize(64);
  EXPECT_EQ(*UploadInfo::decode(bytes), info);
  EXPECT_EQ(UploadInfo::decode(Bytes{bytes}.first(7)).fault().reason, Reason::too_short);
  EXPECT_EQ(UploadInfo::decode(Bytes{bytes}.first(23)).fault().reason, Reason::too_long);
}

TEST(WinchUpload, StopsAtAListThatEndsInsideAnEntry) {
  const V bytes = {5, 0, 0, 0, 9, 8, 0, 0, 0, 1};
  EntryReader reader{bytes};
  EXPECT_EQ((**reader.next()).size(), 5U);
  EXPECT_EQ(reader.next().fault().reason, Reason::too_short);
  const V endless = {0, 0, 0, 0};
  EntryReader stuck{endless};
  EXPECT_FALSE(stuck.next().ok()) << "an entry of length 0 would never end";
}

TEST(WinchLegacy, LaysOutStatusAndCommandAsASumPacksThem) {
  const LegacyStatus status{7, LegacyMode::local, 0.25, -0.25, 0x80004000, 0x4550};
  const V bytes = {7, 0, 0, 0, 1,    0,    0, 0,    0, 0,    0,    0xd0, 0x3f, 0, 0,
                   0, 0, 0, 0, 0xd0, 0xbf, 0, 0x40, 0, 0x80, 0x50, 0x45, 0,    0};
  EXPECT_EQ(encoded(status), bytes);
  EXPECT_EQ(*LegacyStatus::decode(bytes), status);
  const LegacyCommand command{true, LegacyMode::motion_compensation, 0.25};
  const V asked = {1, 3, 0, 0, 0, 0, 0, 0, 0xd0, 0x3f};
  EXPECT_EQ(encoded(command), asked);
  EXPECT_EQ(*LegacyCommand::decode(asked), command);
}

TEST(WinchLegacy, RefusesWhatIsShortLongNotFiniteOrOfNoMode) {
  V status = encoded(LegacyStatus{});
  V command = encoded(LegacyCommand{});
  for (std::size_t n = 0; n < status.size(); ++n) {
    EXPECT_EQ(LegacyStatus::decode(Bytes{status}.first(n)).fault().reason, Reason::too_short);
  }
  for (std::size_t n = 0; n < command.size(); ++n) {
    EXPECT_EQ(LegacyCommand::decode(Bytes{command}.first(n)).fault().reason, Reason::too_short);
  }
  status[4] = 4;
  EXPECT_EQ(LegacyStatus::decode(status).fault().reason, Reason::bad_value);
  command[1] = 4;
  EXPECT_EQ(LegacyCommand::decode(command).fault().reason, Reason::bad_value);
  LegacyCommand endless;
  endless.velocity_mps = std::numeric_limits<double>::infinity();
  EXPECT_EQ(LegacyCommand::decode(encoded(endless)).fault().reason, Reason::bad_value);
  status.push_back(0);
  EXPECT_EQ(LegacyStatus::decode(status).fault().reason, Reason::too_long);
}

TEST(WinchLegacy, KeepsTheFunctionBlocksPublishedOffsets) {
  const auto at = [](std::string_view name) {
    for (const auto& symbol : legacy_symbols()) {
      if (symbol.name == name) return symbol.offset;
    }
    return 0xFFFFU;
  };
  EXPECT_EQ(at("MAIN.winch.Ts"), 8U);
  EXPECT_EQ(at("MAIN.winch.bEnable"), 16U);
  EXPECT_EQ(at("MAIN.winch.eModeCmd"), 17U);
  EXPECT_EQ(at("MAIN.winch.u"), 24U);
  EXPECT_EQ(at("MAIN.winch.uRemote"), 32U);
  EXPECT_EQ(at("MAIN.winch.bActive"), 40U);
  EXPECT_EQ(at("MAIN.winch.eMode"), 41U);
  EXPECT_EQ(at("MAIN.winch.length"), 48U);
  EXPECT_EQ(at("MAIN.winch.length_t"), 56U);
  EXPECT_EQ(at("MAIN.winch.length_tt"), 64U);
  for (const auto& symbol : legacy_symbols()) EXPECT_LE(symbol.offset + symbol.size, kLegacyMemorySize);
}

}  // namespace
}  // namespace motionlab::winch
