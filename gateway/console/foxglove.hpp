/// @file  The Foxglove WebSocket protocol, version 1: what is said and what is understood. Knows no socket.
/// https://github.com/foxglove/ws-protocol/blob/main/docs/spec.md
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace motionlab::console::foxglove {

inline constexpr std::string_view kSubprotocol = "foxglove.websocket.v1";

enum class Level { info = 0, warning = 1, error = 2 };

// --- what the console says

[[nodiscard]] std::string server_info(bool control, std::string_view session);
[[nodiscard]] std::string advertise(std::span<const std::uint32_t> channels);
[[nodiscard]] std::string unadvertise(std::span<const std::uint32_t> channels);
[[nodiscard]] std::string status(Level level, std::string_view message);
/// A status besides which the number stands by itself, for our page: `missed`, all that this client has
/// missed.
[[nodiscard]] std::string missed_status(std::string_view message, std::uint64_t missed);
/// The answer to `Authorize`.
[[nodiscard]] std::string authorized(bool granted);

/// The bytes before the payload of one message: opcode 1, subscription, receive time.
using Header = std::array<std::uint8_t, 13>;
[[nodiscard]] Header message_header(std::uint32_t subscription, std::int64_t t_ns) noexcept;

// --- what a client says

struct Subscribe {
  struct One {
    std::uint32_t subscription = 0, channel = 0;
  };
  std::vector<One> all;
};
struct Unsubscribe {
  std::vector<std::uint32_t> subscriptions;
};
struct Advertise {
  struct One {
    std::uint32_t channel = 0;
    std::string topic, encoding;
  };
  std::vector<One> all;
};
struct Unadvertise {
  std::vector<std::uint32_t> channels;
};
/// Ours, no part of the protocol: shows the token, so that it need not stand in an address.
struct Authorize {
  std::string token;
};
using ClientText = std::variant<Subscribe, Unsubscribe, Advertise, Unadvertise, Authorize>;

/// Any bytes. @returns what was meant, or a sentence that says what is wrong with it
[[nodiscard]] std::variant<ClientText, std::string> read_text(std::string_view text);

/// A message on a channel of the client's.
struct ClientMessage {
  std::uint32_t channel = 0;
  std::string_view payload;
};
[[nodiscard]] std::variant<ClientMessage, std::string> read_binary(std::string_view bytes);

}  // namespace motionlab::console::foxglove
