/// @file  AMS addresses, the AMS/TCP and AMS headers, and the splitter that finds frames in a TCP stream.
/// Source: Beckhoff "AMS/TCP packet" (tc3_ads_intro 115845259, 115847307).
#pragma once

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "drivers/core/bytes.hpp"
#include "drivers/core/result.hpp"

namespace motionlab::winch {

/// A logical machine address. Usually the IP address followed by .1.1, but not bound to it.
struct NetId {
  std::array<std::uint8_t, 6> numbers{};  ///< in written order

  auto operator<=>(const NetId&) const = default;

  /// Parses "192.168.90.150.1.1". @throws StartupError that names the text and shows the wanted form.
  static NetId parse(std::string_view text);
};

[[nodiscard]] std::string to_string(const NetId& net_id);

/// Who speaks: a machine and one of its AMS ports.
struct AmsAddress {
  NetId net_id{};
  std::uint16_t port = 0;

  auto operator<=>(const AmsAddress&) const = default;
};

namespace ams_port {
inline constexpr std::uint16_t plc_runtime_1 = 851;
inline constexpr std::uint16_t system_service = 10000;
}  // namespace ams_port

/// What an AMS/TCP frame carries. All but `ads` are spoken between a program and a router on its own host.
enum class TcpCommand : std::uint16_t {
  ads = 0x0000,
  port_close = 0x0001,
  port_connect = 0x1000,
  router_note = 0x1001,
  local_net_id = 0x1002,
};

/// Bits of the AMS header's state flags.
namespace state_flag {
inline constexpr std::uint16_t response = 0x0001;
inline constexpr std::uint16_t no_return = 0x0002;
inline constexpr std::uint16_t ads_command = 0x0004;
}  // namespace state_flag

inline constexpr std::uint16_t kRequestFlags = state_flag::ads_command;  ///< of requests and of notifications
inline constexpr std::uint16_t kResponseFlags = state_flag::ads_command | state_flag::response;

inline constexpr std::size_t kTcpHeaderSize = 6;
inline constexpr std::size_t kAmsHeaderSize = 32;
inline constexpr std::size_t kFrameHeaderSize = kTcpHeaderSize + kAmsHeaderSize;
inline constexpr std::size_t kBodySizeMax = std::size_t{1}
                                            << 20;  ///< longest body of a frame we believe, 1 MiB

/// The 32 bytes in front of every ADS command. The length of the data is that of the data at hand.
struct AmsHeader {
  AmsAddress target{};
  AmsAddress source{};
  std::uint16_t command = 0;
  std::uint16_t flags = kRequestFlags;
  std::uint32_t error = 0;  ///< routing level: not zero means that the request never reached the ADS device
  std::uint32_t invoke_id = 0;  ///< chosen by the client, echoed by the server

  bool operator==(const AmsHeader&) const = default;

  [[nodiscard]] bool is_response() const noexcept { return (flags & state_flag::response) != 0; }
  /// The header of the answer: addresses swapped, response flag set, same command and invoke id.
  [[nodiscard]] AmsHeader reply(std::uint32_t ams_error = 0) const noexcept {
    return {source, target, command, kResponseFlags, ams_error, invoke_id};
  }
};

/// One AMS/TCP frame without its 6-byte header. The bytes are the splitter's.
struct TcpFrame {
  TcpCommand command{};
  Bytes body{};
};

/// An ADS command with its header. The data are a view into the frame.
struct AmsFrame {
  AmsHeader header{};
  Bytes data{};
};

/// Reads the AMS header of a frame's body.
/// Faults: too_short (less than 32 bytes, or less than the header's length says), too_long (more).
[[nodiscard]] Result<AmsFrame> decode_ams(Bytes body) noexcept;

/// Writes one whole frame, both headers included, around a message with `void encode(LittleWriter&) const`.
/// @returns the bytes written, a part of `to`; too_long when `to` is too small.
template <class Message>
[[nodiscard]] Result<Bytes> encode_frame(MutableBytes to, const AmsHeader& header,
                                         const Message& message) noexcept;

/// Writes a frame that is not an ADS command (port connect and port close).
[[nodiscard]] Result<Bytes> encode_tcp_frame(MutableBytes to, TcpCommand command, Bytes body) noexcept;

/// A message without bytes: the data of requests that carry none, and of answers with an AMS error.
struct NoData {
  void encode(LittleWriter&) const noexcept {}
};

/// Finds frames in a byte stream, however the stream was cut. Frames of several chunks and several frames of
/// one chunk both work. After a fault the stream has no meaning any more: close it and `reset`.
class FrameSplitter {
 public:
  /// @param body_max  longest body accepted; what claims more is a fault before it is stored
  explicit FrameSplitter(std::size_t body_max = kBodySizeMax);

  /// Adds what has arrived. Views given out before are void. Allocates only when a frame is longer than any
  /// before.
  void append(Bytes bytes);
  /// The next whole frame, or nothing when it has not arrived yet; valid until the next `append` or `reset`.
  /// Faults: bad_header (unknown AMS/TCP command), too_short (an ADS frame under 32 bytes), too_long.
  [[nodiscard]] Result<std::optional<TcpFrame>> next() noexcept;
  /// Forgets everything: a new stream begins.
  void reset() noexcept;

 private:
  std::size_t body_max_;
  ByteBuffer buffer_;
  std::size_t begin_ = 0;
  std::optional<Fault> fault_;
};

namespace detail {
/// Reserves both headers; the message follows.
void begin_frame(LittleWriter& writer, const AmsHeader& header) noexcept;
/// Fills in the two lengths.
void finish_frame(MutableBytes frame) noexcept;
}  // namespace detail

template <class Message>
Result<Bytes> encode_frame(MutableBytes to, const AmsHeader& header, const Message& message) noexcept {
  LittleWriter writer{to};
  detail::begin_frame(writer, header);
  message.encode(writer);
  if (!writer.ok()) return Fault{Reason::too_long, "the message does not fit into the frame buffer"};
  detail::finish_frame(to.first(writer.position()));
  return writer.written();
}

}  // namespace motionlab::winch
