#include "drivers/winch/winch_wire_symbols.hpp"

#include <algorithm>

#include "drivers/winch/winch_wire_text.hpp"

namespace motionlab::winch {

namespace {

constexpr std::size_t kEntryFixedSize = 30;

std::uint16_t length_of(std::string_view text) noexcept {
  return static_cast<std::uint16_t>(text.size());
}

char lower(char c) noexcept {
  return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}

}  // namespace

void SymbolPlace::encode(LittleWriter& writer) const noexcept {
  writer.write(index_group);
  writer.write(index_offset);
  writer.write(size);
}

Result<SymbolPlace> SymbolPlace::decode(Bytes bytes) noexcept {
  LittleReader reader{bytes};
  SymbolPlace place;
  place.index_group = reader.read<std::uint32_t>();
  place.index_offset = reader.read<std::uint32_t>();
  place.size = reader.read<std::uint32_t>();
  if (!reader.ok()) return Fault{Reason::too_short, "symbol place shorter than 12 bytes"};
  if (reader.remaining() > 0) return Fault{Reason::too_long, "symbol place longer than 12 bytes"};
  return place;
}

void SymbolEntry::encode(LittleWriter& writer) const noexcept {
  const std::size_t texts = name.size() + type.size() + comment.size() + 3;
  writer.write(static_cast<std::uint32_t>(kEntryFixedSize + texts));
  place.encode(writer);
  writer.write(static_cast<std::uint32_t>(data_type));
  writer.write(flags);
  writer.write(length_of(name));
  writer.write(length_of(type));
  writer.write(length_of(comment));
  write_text(writer, name);
  write_text(writer, type);
  write_text(writer, comment);
}

Result<SymbolEntry> SymbolEntry::decode(Bytes bytes) noexcept {
  LittleReader reader{bytes};
  const auto length = reader.read<std::uint32_t>();
  SymbolEntry entry;
  entry.place.index_group = reader.read<std::uint32_t>();
  entry.place.index_offset = reader.read<std::uint32_t>();
  entry.place.size = reader.read<std::uint32_t>();
  entry.data_type = static_cast<DataType>(reader.read<std::uint32_t>());
  entry.flags = reader.read<std::uint32_t>();
  const std::size_t name_length = reader.read<std::uint16_t>();
  const std::size_t type_length = reader.read<std::uint16_t>();
  const std::size_t comment_length = reader.read<std::uint16_t>();
  entry.name = read_text(reader, name_length);
  entry.type = read_text(reader, type_length);
  entry.comment = read_text(reader, comment_length);
  if (!reader.ok()) return Fault{Reason::too_short, "symbol entry shorter than its own lengths"};
  if (length != bytes.size())
    return Fault{Reason::bad_header, "symbol entry's length is not that of the answer"};
  return entry;
}

void LongHandle::encode(LittleWriter& writer) const noexcept {
  writer.write(handle);
  writer.write(size);
  writer.write(type_decoration);
  writer.write(length_of(type));
  write_text(writer, type);
}

std::string_view symbol_name(Bytes bytes) noexcept {
  const auto text = as_text(bytes);
  return text.substr(0, text.find('\0'));
}

bool same_name(std::string_view a, std::string_view b) noexcept {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](char x, char y) { return lower(x) == lower(y); });
}

}  // namespace motionlab::winch
