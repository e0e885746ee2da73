/// @file  What all sentences of text have in common: `$`, fields between commas, `*hh` (the XOR of what lies
/// between `$` and `*`), CR LF.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "drivers/core/bytes.hpp"
#include "drivers/core/result.hpp"

namespace motionlab::mru::sentence {

enum class Checksum : std::uint8_t { absent, good, bad };

/// A sentence without what encloses it.
struct Opened {
  std::string_view body;  ///< name and fields, with the commas between them
  Checksum checksum = Checksum::absent;
};

/// Takes off what encloses a sentence. One hexadecimal digit is enough for a checksum below 16: some units
/// drop the leading zero.
/// Faults: too_short (nothing, or no CR LF), too_long, bad_header (no `$`). Never throws or allocates.
[[nodiscard]] Result<Opened> open(std::string_view text, std::size_t longest) noexcept;

/// Takes the first field off the rest of a body.
[[nodiscard]] std::string_view take_field(std::string_view& rest) noexcept;
/// How many fields there are.
[[nodiscard]] std::size_t field_count(std::string_view fields) noexcept;
/// A decimal number without an exponent; NaN for an empty field; nothing for anything else.
[[nodiscard]] std::optional<double> number(std::string_view field) noexcept;

/// Writes one sentence, field by field.
class Writer {
 public:
  explicit Writer(MutableBytes to) noexcept;

  void put(std::string_view text) noexcept { writer_.write_bytes(as_bytes(text)); }
  /// NaN as an empty field.
  void put(double value, int decimals) noexcept;
  /// Closes the sentence. @returns its bytes; too_short when there was no room
  [[nodiscard]] Result<Bytes> finish() noexcept;

 private:
  MutableBytes to_;
  LittleWriter writer_;
  bool failed_ = false;
};

}  // namespace motionlab::mru::sentence
