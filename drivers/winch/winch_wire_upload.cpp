#include "drivers/winch/winch_wire_upload.hpp"

#include "drivers/winch/winch_wire_text.hpp"

namespace motionlab::winch {

namespace {

constexpr std::size_t kLengthSize = sizeof(std::uint32_t);
constexpr std::size_t kFixedSize = 42;
constexpr std::size_t kDimensionSize = 8;  // lower bound, number of elements
constexpr std::uint32_t kVersion = 1;
constexpr std::size_t kInfoShort = 8;
constexpr std::size_t kInfoSize = 24;
constexpr std::size_t kInfoLong = 64;

std::size_t own_size(const DataTypeEntry& entry) noexcept {
  return kFixedSize + entry.name.size() + entry.type.size() + entry.comment.size() + 3 +
         (entry.array_elements > 0 ? kDimensionSize : 0);
}

void write_own(LittleWriter& writer, const DataTypeEntry& entry, std::size_t length,
               std::size_t members) noexcept {
  writer.write(static_cast<std::uint32_t>(length));
  writer.write(kVersion);
  writer.write(std::uint32_t{0});  // hash of the entry
  writer.write(std::uint32_t{0});  // hash of its type
  writer.write(entry.size);
  writer.write(entry.offset);
  writer.write(static_cast<std::uint32_t>(entry.data_type));
  writer.write(entry.flags);
  writer.write(static_cast<std::uint16_t>(entry.name.size()));
  writer.write(static_cast<std::uint16_t>(entry.type.size()));
  writer.write(static_cast<std::uint16_t>(entry.comment.size()));
  writer.write(static_cast<std::uint16_t>(entry.array_elements > 0 ? 1 : 0));
  writer.write(static_cast<std::uint16_t>(members));
  write_text(writer, entry.name);
  write_text(writer, entry.type);
  write_text(writer, entry.comment);
  if (entry.array_elements > 0) {
    writer.write(std::int32_t{0});
    writer.write(entry.array_elements);
  }
}

}  // namespace

void UploadInfo::encode_short(LittleWriter& writer) const noexcept {
  writer.write(symbols);
  writer.write(symbol_bytes);
}

void UploadInfo::encode(LittleWriter& writer) const noexcept {
  encode_short(writer);
  writer.write(types);
  writer.write(type_bytes);
  writer.write(dynamic_max);
  writer.write(dynamic_used);
}

Result<UploadInfo> UploadInfo::decode(Bytes bytes) noexcept {
  if (bytes.size() < kInfoShort) return Fault{Reason::too_short, "upload info has 8, 24 or 64 bytes"};
  if (bytes.size() != kInfoShort && bytes.size() != kInfoSize && bytes.size() != kInfoLong) {
    return Fault{Reason::too_long, "upload info has 8, 24 or 64 bytes"};
  }
  LittleReader reader{bytes};
  UploadInfo info;
  info.symbols = reader.read<std::uint32_t>();
  info.symbol_bytes = reader.read<std::uint32_t>();
  if (bytes.size() == kInfoShort) return info;
  info.types = reader.read<std::uint32_t>();
  info.type_bytes = reader.read<std::uint32_t>();
  info.dynamic_max = reader.read<std::uint32_t>();
  info.dynamic_used = reader.read<std::uint32_t>();
  return info;
}

Result<std::optional<Bytes>> EntryReader::next() noexcept {
  constexpr Fault kCut{Reason::too_short, "a list of entries ends inside one"};
  if (rest_.empty()) return std::optional<Bytes>{};
  if (rest_.size() < kLengthSize) return kCut;
  const std::size_t length = load<std::uint32_t, std::endian::little>(rest_);
  if (length < kLengthSize || length > rest_.size()) return kCut;
  const Bytes entry = rest_.first(length);
  rest_ = rest_.subspan(length);
  return std::optional{entry};
}

void DataTypeEntry::encode(LittleWriter& writer, std::span<const DataTypeEntry> of_members) const noexcept {
  std::size_t length = own_size(*this);
  for (const auto& member : of_members) length += own_size(member);
  write_own(writer, *this, length, of_members.size());
  for (const auto& member : of_members) write_own(writer, member, own_size(member), 0);
}

Result<DataTypeEntry> DataTypeEntry::decode(Bytes bytes) noexcept {
  LittleReader reader{bytes};
  const std::size_t length = reader.read<std::uint32_t>();
  reader.skip(3 * sizeof(std::uint32_t));  // version, two hashes
  DataTypeEntry entry;
  entry.size = reader.read<std::uint32_t>();
  entry.offset = reader.read<std::uint32_t>();
  entry.data_type = static_cast<DataType>(reader.read<std::uint32_t>());
  entry.flags = reader.read<std::uint32_t>();
  const std::size_t name_length = reader.read<std::uint16_t>();
  const std::size_t type_length = reader.read<std::uint16_t>();
  const std::size_t comment_length = reader.read<std::uint16_t>();
  const auto dimensions = reader.read<std::uint16_t>();
  entry.members = reader.read<std::uint16_t>();
  entry.name = read_text(reader, name_length);
  entry.type = read_text(reader, type_length);
  entry.comment = read_text(reader, comment_length);
  if (dimensions > 1) return Fault{Reason::bad_value, "a PLC array of several dimensions"};
  if (dimensions == 1) {
    if (reader.read<std::int32_t>() != 0)
      return Fault{Reason::bad_value, "a PLC array that does not begin at 0"};
    entry.array_elements = reader.read<std::uint32_t>();
  }
  if (!reader.ok()) return Fault{Reason::too_short, "data type entry shorter than its own lengths"};
  if (length != bytes.size())
    return Fault{Reason::bad_header, "data type entry's length is not that of the answer"};
  const std::size_t begin = reader.position();
  EntryReader walk{bytes.subspan(begin)};
  std::size_t members_size = 0;
  for (std::uint16_t i = 0; i < entry.members; ++i) {
    const auto member = walk.next();
    if (!member) return member.fault();
    if (!*member) return Fault{Reason::too_short, "data type entry lacks some of its members"};
    members_size += (**member).size();
  }
  entry.member_entries = bytes.subspan(begin, members_size);
  return entry;
}

}  // namespace motionlab::winch
