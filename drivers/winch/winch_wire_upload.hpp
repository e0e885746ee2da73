/// @file  What a PLC tells about all of its symbols and types at once: upload info, entries back to back,
/// data types. The gateway does not ask for them; other people's clients do. Source: Beckhoff AdsDef
/// (AdsSymbolUploadInfo2, AdsSymbolEntry, AdsDatatypeEntry).
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "drivers/core/bytes.hpp"
#include "drivers/core/result.hpp"
#include "drivers/winch/winch_wire_symbols.hpp"

namespace motionlab::winch {

/// Answer of index groups 0xF00C (its first 8 bytes) and 0xF00F (24 bytes).
struct UploadInfo {
  std::uint32_t symbols = 0;
  std::uint32_t symbol_bytes = 0;
  std::uint32_t types = 0;
  std::uint32_t type_bytes = 0;
  std::uint32_t dynamic_max = 0;
  std::uint32_t dynamic_used = 0;

  bool operator==(const UploadInfo&) const = default;
  void encode_short(LittleWriter& writer) const noexcept;
  void encode(LittleWriter& writer) const noexcept;
  /// Takes 8, 24 or 64 bytes; what is missing is zero, what is beyond 24 is passed over.
  /// Faults: too_short, too_long (any other size).
  [[nodiscard]] static Result<UploadInfo> decode(Bytes bytes) noexcept;
};

/// Walks through entries that each begin with their own length, as 0xF00B and 0xF00E answer.
class EntryReader {
 public:
  explicit EntryReader(Bytes bytes) noexcept : rest_(bytes) {}

  /// The bytes of the next entry, its length field included; nothing at the end.
  /// Faults: too_short (an entry ends behind the bytes, or is shorter than its length field).
  [[nodiscard]] Result<std::optional<Bytes>> next() noexcept;

 private:
  Bytes rest_;
};

/// One data type, or one member of one: 0xF011, 0xF00E. Texts and bytes are views.
struct DataTypeEntry {
  std::uint32_t size = 0;
  std::uint32_t offset = 0;  ///< of a member, in its struct
  DataType data_type{};
  std::uint32_t flags = 0;
  std::string_view name{};
  std::string_view type{};  ///< of a member, or of an array's elements
  std::string_view comment{};
  std::uint32_t array_elements = 0;  ///< 0: no array; else ARRAY [0..n-1], the only form that we use
  std::uint16_t members = 0;
  Bytes member_entries{};  ///< when decoded: the members, for an EntryReader; ignored when encoding

  /// Writes the entry and its members behind it. A struct's members have none themselves.
  void encode(LittleWriter& writer, std::span<const DataTypeEntry> of_members = {}) const noexcept;
  /// Bytes behind the last member belong to newer entries and are passed over.
  /// Faults: too_short, bad_header (the entry's length is not that of the bytes), bad_value (an array of
  /// several dimensions, or one that does not begin at 0).
  [[nodiscard]] static Result<DataTypeEntry> decode(Bytes bytes) noexcept;
};

namespace data_type_flag {
inline constexpr std::uint32_t data_type = 0x1;
inline constexpr std::uint32_t data_item = 0x2;
}  // namespace data_type_flag

}  // namespace motionlab::winch
