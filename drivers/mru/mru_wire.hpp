/// @file  "MRU normal" (`MRUBIN`) of a Kongsberg Seatex motion reference unit: bytes to frame and back.
///
/// Datagram: header `q` (settled) or `Q` (not settled) · length = 1 + 4 N · token · N values of four bytes,
/// big-endian · checksum. Size = length + 3. Source: Reson SeaBat 8160 manual p. 79 and 8101 manual p. 6-24
/// (framing, example); the laboratory's MRU configuration (variables, tokens).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <optional>

#include "drivers/core/bytes.hpp"
#include "drivers/core/result.hpp"
#include "drivers/mru/mru_wire_variables.hpp"

namespace motionlab::mru {

inline constexpr std::uint8_t kStableHeader = 0x71;    ///< `q`
inline constexpr std::uint8_t kUnstableHeader = 0x51;  ///< `Q`: start-up or alignment
inline constexpr std::size_t kOverhead = 4;            ///< header, length, token, checksum
inline constexpr std::size_t kMaxDatagram = kOverhead + 4 * kMaxVariables;

/// What the values can mean on a platform. A value beyond its limit refuses the whole datagram.
struct PlausibilityLimits {
  double tilt_rad = static_cast<double>(std::numbers::pi_v<float> / 2);  ///< of |roll| and |pitch|
  double heave_m = 10.0;                                                 ///< of |PosCg_D|
  double rate_radps = 10.0;                                              ///< of each rate of turn
};

/// Whether a variable can have this value. @returns bad_value with a text that names the quantity
[[nodiscard]] Status check_plausible(const VariableFacts& facts, double value,
                                     const PlausibilityLimits& limits) noexcept;

/// What one port expects.
struct Layout {
  VariableList variables = VariableList::laboratory();
  std::uint8_t token = 11;  ///< chosen by the user of the unit; laboratory: 11 on EM8000, 12 on EM1500
  PlausibilityLimits limits{};
  bool text_in_degrees = false;  ///< of NMEAP, the same list as text: what the unit is set to

  /// Bytes of a whole datagram of MRUBIN; 100 for the laboratory's list.
  [[nodiscard]] std::size_t datagram_size() const noexcept { return kOverhead + 4 * variables.size(); }
};

/// The two rules that the last byte may follow. Which one the unit uses is not documented; one published
/// frame agrees with `ones_complement`, one published program with `sum8`.
enum class ChecksumRule : std::uint8_t {
  sum8,             ///< 8-bit sum of token … last value byte
  ones_complement,  ///< the same bytes added with end-around carry, then inverted
};

/// Which rules the checksum byte of a datagram agrees with. Under `ones_complement` 0x00 and 0xFF are the
/// same number (the two zeros of that arithmetic).
struct ChecksumMatch {
  bool sum8 = false;
  bool ones_complement = false;

  [[nodiscard]] bool of(ChecksumRule rule) const noexcept {
    return rule == ChecksumRule::sum8 ? sum8 : ones_complement;
  }
};

/// The checksum byte over token … last value byte.
[[nodiscard]] std::uint8_t checksum(ChecksumRule rule, Bytes token_and_data) noexcept;

/// One datagram, raw: values in the order of the layout, units as in its variable table (SI; ms and degC
/// excepted).
struct Frame {
  bool stable = true;
  std::uint8_t token = 0;
  std::uint8_t checksum = 0;
  ChecksumMatch checksum_match{};
  std::size_t size = 0;  ///< number of values
  std::array<double, kMaxVariables> values{};

  /// The value of a variable; nothing when the layout lacks it.
  [[nodiscard]] std::optional<double> value(Variable variable, const Layout& layout) const noexcept;
  /// SystemTime in ms since power-on as it counts: modulo 2^32. The wire carries it as a signed number.
  [[nodiscard]] std::optional<std::uint32_t> system_time_ms(const Layout& layout) const noexcept;
};

/// Reads one datagram. Faults, each with a text of its own: too_short, too_long (size is not length + 3),
/// bad_header (header byte, length byte, token, number of variables), bad_value (not finite, implausible). A
/// checksum that does not match is no fault here: see `Frame::checksum_match`. Never throws or allocates.
[[nodiscard]] Result<Frame> decode(Bytes datagram, const Layout& layout) noexcept;

/// Writes one datagram for `frame.values` (as many as the layout has) with the frame's header flag and the
/// layout's token. Values are sent as they are, NaN included: the simulated unit must be able to lie.
/// @returns the bytes written, or too_short when `to` has no room, bad_value when an integer is not finite.
[[nodiscard]] Result<Bytes> encode(const Frame& frame, const Layout& layout, ChecksumRule rule,
                                   MutableBytes to) noexcept;

}  // namespace motionlab::mru
