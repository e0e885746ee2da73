/// @file  "NMEA proprietary" of a Kongsberg Seatex motion reference unit: `$PSXN,10,token,value,…*hh` when it
/// has settled, `$PSXN,11,…` before. MRUBIN as text: the values are the user's list of variables.
///
/// Source: the unit's list of protocols (`NMEAP`) and a receiver's manual. Whether the unit is set to radians
/// (the maker's default) or degrees the sentence does not tell.
#pragma once

#include <cstddef>
#include <string_view>

#include "drivers/core/bytes.hpp"
#include "drivers/core/result.hpp"
#include "drivers/mru/mru_wire.hpp"
#include "drivers/mru/mru_wire_sentence.hpp"

namespace motionlab::mru::nmeap {

/// Terminator included; 63 variables of 15 characters fit.
inline constexpr std::size_t kMaxSentence = 1024;
/// What begins a sentence of a settled unit, and of one that has not settled.
inline constexpr std::string_view kSettled = "PSXN,10,", kUnsettled = "PSXN,11,";

/// One sentence: values in SI, as MRUBIN has them, in the order of the layout. Its checksum byte is not used.
struct Sentence {
  Frame frame;
  sentence::Checksum checksum = sentence::Checksum::absent;
};

/// Reads one sentence, terminator included.
/// Faults: too_short, too_long, bad_header (no such sentence, token, number of variables), bad_value (a field
/// that is no number or empty, implausible). Never throws or allocates.
[[nodiscard]] Result<Sentence> decode(std::string_view text, const Layout& layout) noexcept;

/// Writes one sentence: degrees with two decimals, radians (and all else beside them) with six, times whole;
/// NaN as an empty field.
/// @returns the bytes written; too_short when `to` has no room
[[nodiscard]] Result<Bytes> encode(const Frame& frame, const Layout& layout, MutableBytes to) noexcept;

}  // namespace motionlab::mru::nmeap
