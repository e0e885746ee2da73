/// @file  An IPv4 address and a port, as text and as value.
#pragma once

#include <compare>
#include <cstdint>
#include <string>
#include <string_view>

namespace motionlab {

/// Where a datagram comes from or goes to. Address 0 means any.
struct Endpoint {
  std::uint32_t address = 0;  ///< host byte order
  std::uint16_t port = 0;

  auto operator<=>(const Endpoint&) const = default;

  /// Parses "192.168.90.13:50013". @throws StartupError that names the text and shows the wanted form.
  static Endpoint parse(std::string_view text);
  /// Parses "192.168.90.13". @throws StartupError likewise.
  static std::uint32_t parse_address(std::string_view text);
};

[[nodiscard]] std::string to_string(const Endpoint& endpoint);
[[nodiscard]] std::string address_to_string(std::uint32_t address);

}  // namespace motionlab
