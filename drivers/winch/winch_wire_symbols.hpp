/// @file  What a PLC tells about its symbols: handles, places, sizes, types.
#pragma once

#include <cstdint>
#include <string_view>

#include "drivers/core/bytes.hpp"
#include "drivers/core/result.hpp"

namespace motionlab::winch {

/// Elementary types of a PLC, as symbol entries number them.
enum class DataType : std::uint32_t {
  int16 = 2,
  int32 = 3,
  real = 4,
  lreal = 5,
  sint = 16,
  byte = 17,
  word = 18,  ///< UINT too
  udint = 19,
  lint = 20,
  ulint = 21,
  string = 30,
  boolean = 33,
  structure = 65,
};

/// Answer of index group 0xF007: 12 bytes.
struct SymbolPlace {
  std::uint32_t index_group = 0;
  std::uint32_t index_offset = 0;
  std::uint32_t size = 0;

  bool operator==(const SymbolPlace&) const = default;
  void encode(LittleWriter& writer) const noexcept;
  [[nodiscard]] static Result<SymbolPlace> decode(Bytes bytes) noexcept;
};

/// Answer of index group 0xF009. Texts are views.
struct SymbolEntry {
  SymbolPlace place{};
  DataType data_type{};
  std::uint32_t flags = 0;
  std::string_view name{};
  std::string_view type{};
  std::string_view comment{};

  bool operator==(const SymbolEntry&) const = default;
  void encode(LittleWriter& writer) const noexcept;
  /// Bytes behind the comment belong to newer entries and are passed over.
  /// Faults: too_short, bad_header (the entry's length is not that of the answer).
  [[nodiscard]] static Result<SymbolEntry> decode(Bytes bytes) noexcept;
};

/// Answer of index group 0xF003 when more than the 4 bytes of a handle were asked for.
struct LongHandle {
  std::uint32_t handle = 0;
  std::uint32_t size = 0;
  std::uint32_t type_decoration = 0;
  std::string_view type{};

  void encode(LittleWriter& writer) const noexcept;
};

/// A name as clients send it: with or without a NUL at the end.
[[nodiscard]] std::string_view symbol_name(Bytes bytes) noexcept;

/// Names of the PLC do not tell apart upper and lower case.
[[nodiscard]] bool same_name(std::string_view a, std::string_view b) noexcept;

}  // namespace motionlab::winch
