/// @file  The sentences `$PSXN,20` to `,24` and `$PRDID`. Degrees, heave + down, no time.
///
/// Sources: Seapath 320 manual p. 95 (PSXN, with examples); the layout of PRDID is Teledyne RD Instruments'.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "drivers/core/bytes.hpp"
#include "drivers/core/result.hpp"
#include "drivers/mru/mru_wire_motion.hpp"
#include "drivers/mru/mru_wire_sentence.hpp"

namespace motionlab::mru::nmea {

/// No sentence of these is longer, terminator included.
inline constexpr std::size_t kMaxSentence = 120;

enum class Kind : std::uint8_t {
  quality,   ///< PSXN,20: horizontal, height, heading, roll and pitch; 0 normal, 1 reduced, 2 invalid
  restart,   ///< PSXN,21: 1 when the unit has restarted
  gyro,      ///< PSXN,22: gyro calibration, gyro offset, deg
  attitude,  ///< PSXN,23: roll, pitch, heading, deg; heave, m, + down
  rates,     ///< PSXN,24: roll, pitch, yaw rate, deg/s; vertical velocity, m/s, + down
  prdid,     ///< PRDID: pitch (first), roll, heading, deg
  other,     ///< well-formed, but none of these; its values are not read
};

/// How many values a sentence of this kind has.
[[nodiscard]] constexpr std::size_t value_count(Kind kind) noexcept {
  constexpr std::array<std::size_t, 7> counts{4, 1, 2, 4, 4, 3, 0};
  return counts[static_cast<std::size_t>(kind)];
}

using sentence::Checksum;

/// One sentence in the wire's units. An empty field is NaN.
struct Sentence {
  Kind kind = Kind::other;
  Checksum checksum = Checksum::absent;
  std::array<double, 4> values{kNotTold, kNotTold, kNotTold, kNotTold};
};

/// Reads one sentence, terminator included.
/// Faults: too_short (no CR LF), too_long, bad_header (no `$`, wrong number of fields), bad_value (a field
/// that is no number). Never throws or allocates.
[[nodiscard]] Result<Sentence> decode(std::string_view text) noexcept;
/// Writes one sentence with its checksum; angles, rates and lengths with two decimals, NaN as an empty field.
/// @returns the bytes written; too_short when `to` has no room; bad_value for `other`
[[nodiscard]] Result<Bytes> encode(const Sentence& sentence, MutableBytes to) noexcept;

/// Puts sentences together: what `20` said of the quality and `24` of the rates belongs to the next `23`.
///
/// Quality holds until the unit says something else, and is normal before its first word. Rates belong to the
/// next two attitudes at most: a unit that has stopped to send them is not credited with old ones. After a
/// restart a unit that speaks of its quality is not stable until it speaks again.
class Listener {
 public:
  /// @param attitude  the sentence that makes a motion: Kind::attitude or Kind::prdid
  explicit Listener(Kind attitude) noexcept : attitude_(attitude) {}

  /// Reads a datagram of one or several sentences. A sentence whose checksum is bad is not remembered.
  /// @returns the last motion in it; nothing when it has none (a `20` alone); the fault of the first bad
  ///          sentence; bad_header when no sentence is of this family (PSXN, or PRDID); bad_checksum when
  ///          none can be believed
  [[nodiscard]] Result<std::optional<Telegram>> take(Bytes datagram) noexcept;

 private:
  [[nodiscard]] bool belongs(Kind kind) const noexcept;
  void remember(const Sentence& sentence) noexcept;
  [[nodiscard]] Telegram tell(const Sentence& sentence) noexcept;

  Kind attitude_;
  bool quality_heard_ = false;
  bool waits_for_quality_ = false;
  int heading_quality_ = 0;
  int roll_pitch_quality_ = 0;
  std::array<double, 4> rates_{};
  int rates_hold_ = 0;  ///< for so many attitudes
};

}  // namespace motionlab::mru::nmea
