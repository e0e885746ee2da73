/// @file  What writer and reader of MCAP files share: magic, opcodes, the names of things. See
/// https://mcap.dev/spec.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>

namespace motionlab::record {

/// At both ends of a file.
inline constexpr std::array<std::uint8_t, 8> kMcapMagic{0x89, 'M', 'C', 'A', 'P', '0', '\r', '\n'};
/// Opcode and length before each record.
inline constexpr std::size_t kRecordHead = 1 + 8;

enum class Opcode : std::uint8_t {
  header = 0x01,
  footer = 0x02,
  schema = 0x03,
  channel = 0x04,
  message = 0x05,
  chunk = 0x06,
  message_index = 0x07,
  chunk_index = 0x08,
  attachment = 0x09,
  attachment_index = 0x0A,
  statistics = 0x0B,
  metadata = 0x0C,
  metadata_index = 0x0D,
  summary_offset = 0x0E,
  data_end = 0x0F,
};

using SchemaId = std::uint16_t;
using ChannelId = std::uint16_t;
using StringMap = std::map<std::string, std::string>;

inline constexpr std::string_view kNoCompression = "";
inline constexpr std::string_view kZstd = "zstd";

}  // namespace motionlab::record
