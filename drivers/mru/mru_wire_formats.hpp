/// @file  All formats behind two doors: a datagram in the configured format to a motion, and back.
#pragma once

#include <optional>

#include "drivers/core/bytes.hpp"
#include "drivers/core/result.hpp"
#include "drivers/mru/mru_wire_motion.hpp"
#include "drivers/mru/mru_wire_nmea.hpp"

namespace motionlab::mru {

/// Reads the datagrams of one port, whose format is known by configuration.
class Decoder {
 public:
  /// @param layout  token and variables of MRUBIN and NMEAP; its limits hold for every format
  Decoder(Format format, const Layout& layout) noexcept;

  /// @returns what the datagram says; nothing for one that is right but carries no attitude (a sentence
  ///          about quality alone); or the fault of the format's own decoder, or bad_value for a motion that
  ///          is not plausible. Never throws or allocates.
  [[nodiscard]] Result<std::optional<Telegram>> decode(Bytes datagram) noexcept;

 private:
  Format format_;
  Layout layout_;
  nmea::Listener listener_;
};

/// Room for a datagram in any of the formats.
inline constexpr std::size_t kRoomForAny = 1024;

/// The values of an MRUBIN frame as a motion. Variables that the layout lacks are NaN.
[[nodiscard]] Motion motion_of(const Frame& frame, const Layout& layout) noexcept;

/// Writes one datagram. PSXN is three sentences in one datagram: quality, rates, attitude. NaN is sent as the
/// format can: as such, as a count out of range, or as an empty field.
/// @param t_unit  the unit's clock: since power-on for MRUBIN and NMEAP, since 1970 for the formats with UTC
/// @param rule    of MRUBIN's checksum
/// @returns the bytes written, or too_short when `to` has no room
[[nodiscard]] Result<Bytes> encode(const Motion& motion, Format format, const Layout& layout,
                                   ChecksumRule rule, Nanoseconds t_unit, MutableBytes to) noexcept;

}  // namespace motionlab::mru
