/// @file  The symbols and types of the simulated PLC's project, and what it tells about all of them at once.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/winch/winch_wire.hpp"

namespace motionlab::winch {

/// Which PLC project is loaded: ours with GVL_Winch, or the laboratory's published one without it.
enum class PlcProject : std::uint8_t { gvl_winch, legacy };

/// Where the project's variables lie within its data area.
inline constexpr std::uint32_t kGvlAt = 0;
inline constexpr std::uint32_t kMainAt = 0x1000;

class SymbolTable {
 public:
  struct Symbol {
    std::string name;
    std::string_view type;
    DataType data_type{};
    std::uint32_t offset = 0;  ///< in the project's data area
    std::uint32_t size = 0;
  };

  explicit SymbolTable(PlcProject project);

  /// The symbol of a name in any case, or nothing.
  [[nodiscard]] const Symbol* find(std::string_view name) const;
  [[nodiscard]] const Symbol& at(std::uint32_t index) const { return symbols_[index]; }
  [[nodiscard]] std::uint32_t index_of(const Symbol& symbol) const {
    return static_cast<std::uint32_t>(&symbol - symbols_.data());
  }
  /// One entry, as 0xF009 answers. `base`: where the data area begins now.
  void write_entry(const Symbol& symbol, std::uint32_t base, LittleWriter& writer) const;
  /// All entries back to back, as 0xF00B answers.
  void write_entries(std::uint32_t base, LittleWriter& writer) const;
  /// @returns false for a type that needs no entry, or is not there
  bool write_type(std::string_view name, LittleWriter& writer) const;
  /// All types back to back, as 0xF00E answers.
  void write_types(LittleWriter& writer) const;
  [[nodiscard]] const UploadInfo& upload_info() const noexcept { return upload_info_; }

 private:
  void add_struct(std::string_view name, std::string_view type, std::span<const Member> members,
                  std::uint32_t offset, std::uint32_t size);

  PlcProject project_;
  std::vector<Symbol> symbols_;
  UploadInfo upload_info_{};
};

}  // namespace motionlab::winch
