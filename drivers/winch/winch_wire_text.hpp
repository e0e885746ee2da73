/// @file  Texts in the entries of symbols and data types: their length stands in the entry's head, and behind
/// each is a NUL that the length does not count.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "drivers/core/bytes.hpp"

namespace motionlab::winch {

inline void write_text(LittleWriter& writer, std::string_view text) noexcept {
  writer.write_bytes(as_bytes(text));
  writer.write(std::uint8_t{0});
}

[[nodiscard]] inline std::string_view read_text(LittleReader& reader, std::size_t length) noexcept {
  const auto text = as_text(reader.take(length));
  reader.skip(1);
  return text;
}

}  // namespace motionlab::winch
