/// @file  How a Qualisys server is found: one broadcast datagram asks, every server answers by one of its
/// own. Sizes and types are little-endian, ports big-endian, whatever the port that is used afterwards.
/// Source: QTM RT Protocol documentation, "Auto discover".
#pragma once

#include <cstdint>
#include <string_view>

#include "drivers/core/bytes.hpp"
#include "drivers/core/result.hpp"

namespace motionlab::qualisys {

/// UDP port on which servers listen. It does not move with the base port.
inline constexpr std::uint16_t kDiscoveryPort = 22226;

/// What a server says of itself.
struct DiscoveryAnswer {
  std::string_view info;        ///< "host, QTM x.y (build z), n cameras"
  std::uint16_t base_port = 0;  ///< 22222: the little-endian port is the next one, not this one
};

/// Reads a question. @returns the UDP port on which the asker listens for answers.
/// Faults: too_short, too_long, bad_header (another size or type), bad_value (port 0).
[[nodiscard]] Result<std::uint16_t> decode_discovery(Bytes datagram) noexcept;
[[nodiscard]] ByteBuffer encode_discovery(std::uint16_t answer_port);

/// Reads an answer; the text is a view into `datagram`.
/// Faults: too_short, too_long, bad_header (another type, or a text without its NUL), bad_value (port 0).
[[nodiscard]] Result<DiscoveryAnswer> decode_discovery_answer(Bytes datagram) noexcept;
[[nodiscard]] ByteBuffer encode_discovery_answer(const DiscoveryAnswer& answer);

}  // namespace motionlab::qualisys
