/// @file  Packets of the Qualisys real-time (RT) protocol: header, framing of the TCP stream, texts and
/// events. Protocol 1.8 and later, on the little-endian port (base + 1) or the big-endian one (base + 2).
/// Source: QTM RT Protocol documentation, "Protocol structure". What is inside a data packet stands in
/// qualisys_wire_data.hpp, the XML in qualisys_wire_xml.hpp, commands in qualisys_wire_command.hpp.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "drivers/core/bytes.hpp"
#include "drivers/core/result.hpp"

namespace motionlab::qualisys {

inline constexpr std::size_t kPacketHeaderSize = 8;
/// What a UDP datagram can carry.
inline constexpr std::size_t kDatagramLimit = 65507;
/// What we believe of a packet on the TCP stream; the XML of a large camera system stays far below.
inline constexpr std::size_t kStreamPacketLimit = std::size_t{1} << 20;

inline constexpr std::string_view kWelcome = "QTM RT Interface connected";
inline constexpr std::string_view kTooManyClients = "Connection refused. Max number of clients reached.";

/// The second word of the header. Other numbers may occur; receivers pass over them.
enum class PacketType : std::uint32_t {
  error = 0,         ///< text from the server: a command failed
  command = 1,       ///< text: a command or its answer
  xml = 2,           ///< text
  data = 3,          ///< one frame (qualisys_wire_data.hpp)
  no_more_data = 4,  ///< empty: nothing is being measured
  event = 6,         ///< one byte: `Event`
  discover = 7,      ///< a datagram of its own port (qualisys_wire_discovery.hpp)
};

/// What happened at the server. Pushed at any time, and the answer to `GetState`. Other numbers may occur.
enum class Event : std::uint8_t {
  connected = 1,          ///< cameras connected, preview runs
  connection_closed = 2,  ///< measurement closed
  capture_started = 3,
  capture_stopped = 4,
  calibration_started = 6,
  calibration_stopped = 7,
  rt_from_file_started = 8,
  rt_from_file_stopped = 9,
  waiting_for_trigger = 10,
  camera_settings_changed = 11,
  shutting_down = 12,
  capture_saved = 13,
  trigger = 16,
};

/// One packet: a view of the bytes it was found in.
struct Packet {
  PacketType type{};
  Bytes payload{};  ///< without the 8-byte header
};

/// Reads a datagram that is exactly one packet, in the byte order of the port that it belongs to.
/// Faults: too_short (no header, or less than the header announces), too_long (more than it announces),
/// bad_header (announces less than the header itself).
[[nodiscard]] Result<Packet> decode_datagram(Bytes datagram,
                                             std::endian order = std::endian::little) noexcept;

/// The text of a packet of type error, command or xml: up to its NUL, or all of it when the sender left the
/// NUL out.
[[nodiscard]] std::string_view packet_text(Bytes payload) noexcept;

/// The event of a packet of type event. Faults: too_short, too_long.
[[nodiscard]] Result<Event> decode_event(Bytes payload) noexcept;

/// A whole packet with this text and the NUL that every vendor client needs from a server.
[[nodiscard]] ByteBuffer encode_text(PacketType type, std::string_view text,
                                     std::endian order = std::endian::little);
[[nodiscard]] ByteBuffer encode_event(Event event, std::endian order = std::endian::little);
[[nodiscard]] ByteBuffer encode_no_more_data(std::endian order = std::endian::little);

/// Cuts a TCP stream into packets, however the bytes arrive.
///
/// Use: `push` what arrived, then call `next` until it yields nothing. Holds at most one unfinished packet of
/// `limit` bytes beside what was pushed last. A size that cannot be (below 8: bad_header, above the limit:
/// too_long) is reported once more at every `next` until `reset`: a stream that has lost its framing cannot
/// be trusted again.
class PacketSplitter {
 public:
  explicit PacketSplitter(std::size_t limit = kStreamPacketLimit,
                          std::endian order = std::endian::little) noexcept
      : limit_(limit), order_(order) {}

  void push(Bytes bytes);
  /// The next whole packet, valid until the next `push` or `reset`; a fault; or nothing yet.
  [[nodiscard]] std::optional<Result<Packet>> next() noexcept;
  /// Forgets everything: a new connection begins.
  void reset() noexcept;
  /// A packet has begun and is not complete.
  [[nodiscard]] bool in_packet() const noexcept { return consumed_ < buffer_.size(); }

 private:
  std::size_t limit_;
  std::endian order_;
  ByteBuffer buffer_;
  std::size_t consumed_ = 0;
};

}  // namespace motionlab::qualisys
