#include "simulators/winch/winch_device_symbols.hpp"

#include <algorithm>
#include <array>

#include "simulators/winch/winch_device_plc.hpp"

namespace motionlab::winch {

namespace {

constexpr std::uint32_t kSymbolFlags = 0x8;  // has a type name
constexpr std::string_view kArrayType = "ARRAY [0..1] OF BYTE";
constexpr std::size_t kUploadMax = 16 * 1024;

DataTypeEntry of_member(const Member& member) {
  return {member.size,
          member.offset,
          member.data_type,
          data_type_flag::data_item,
          member.name,
          member.type,
          {},
          0,
          0,
          {}};
}

/// A member only names the type of its array; the elements are told here.
void write_array(LittleWriter& writer) {
  DataTypeEntry{2, 0, DataType::byte, data_type_flag::data_type, kArrayType, "BYTE", {}, 2, 0, {}}.encode(
      writer);
}

void write_struct(std::string_view name, std::span<const Member> members, std::uint32_t size,
                  LittleWriter& writer) {
  std::vector<DataTypeEntry> entries;
  entries.reserve(members.size());
  for (const auto& member : members) entries.push_back(of_member(member));
  const DataTypeEntry entry{size, 0, DataType::structure, data_type_flag::data_type, name, {}, {}, 0, 0, {}};
  entry.encode(writer, entries);
}

}  // namespace

SymbolTable::SymbolTable(PlcProject project) : project_(project) {
  if (project == PlcProject::gvl_winch) {
    add_struct("GVL_Winch.stCommand", kCommandType, command_members(), kGvlAt + PlcProgram::kCommandAt,
               kCommandSize);
    add_struct("GVL_Winch.stStatus", kStatusType, status_members(), kGvlAt + PlcProgram::kStatusAt,
               kStatusSize);
  }
  for (const auto& symbol : legacy_symbols()) {
    symbols_.push_back(
        {std::string{symbol.name}, symbol.type, symbol.data_type, kMainAt + symbol.offset, symbol.size});
  }
  std::array<std::uint8_t, kUploadMax> scratch{};
  LittleWriter entries{scratch};
  write_entries(0, entries);
  upload_info_.symbols = static_cast<std::uint32_t>(symbols_.size());
  upload_info_.symbol_bytes = static_cast<std::uint32_t>(entries.position());
  LittleWriter types{scratch};
  write_types(types);
  upload_info_.types = project == PlcProject::gvl_winch ? 3 : 0;
  upload_info_.type_bytes = static_cast<std::uint32_t>(types.position());
}

void SymbolTable::add_struct(std::string_view name, std::string_view type, std::span<const Member> members,
                             std::uint32_t offset, std::uint32_t size) {
  symbols_.push_back({std::string{name}, type, DataType::structure, offset, size});
  for (const auto& member : members) {
    symbols_.push_back({std::string{name} + "." + std::string{member.name}, member.type, member.data_type,
                        offset + member.offset, member.size});
  }
}

const SymbolTable::Symbol* SymbolTable::find(std::string_view name) const {
  const auto found = std::find_if(symbols_.begin(), symbols_.end(),
                                  [&](const Symbol& s) { return same_name(s.name, name); });
  return found == symbols_.end() ? nullptr : &*found;
}

void SymbolTable::write_entry(const Symbol& symbol, std::uint32_t base, LittleWriter& writer) const {
  const SymbolPlace place{index_group::plc_data, base + symbol.offset, symbol.size};
  SymbolEntry{place, symbol.data_type, kSymbolFlags, symbol.name, symbol.type, {}}.encode(writer);
}

void SymbolTable::write_entries(std::uint32_t base, LittleWriter& writer) const {
  for (const auto& symbol : symbols_) write_entry(symbol, base, writer);
}

bool SymbolTable::write_type(std::string_view name, LittleWriter& writer) const {
  if (project_ != PlcProject::gvl_winch) return false;
  if (same_name(name, kCommandType)) {
    write_struct(kCommandType, command_members(), kCommandSize, writer);
  } else if (same_name(name, kStatusType)) {
    write_struct(kStatusType, status_members(), kStatusSize, writer);
  } else if (same_name(name, kArrayType)) {
    write_array(writer);
  } else {
    return false;
  }
  return true;
}

void SymbolTable::write_types(LittleWriter& writer) const {
  for (const auto name : {kCommandType, kStatusType, kArrayType}) (void)write_type(name, writer);
}

}  // namespace motionlab::winch
