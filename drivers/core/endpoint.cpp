#include "drivers/core/endpoint.hpp"

#include <charconv>

#include "drivers/core/error.hpp"

namespace motionlab {
namespace {

/// Parses a decimal number of at most `maximum` and moves `text` behind it.
bool take_number(std::string_view& text, std::uint32_t maximum, std::uint32_t& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || value > maximum) return false;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return true;
}

bool take_address(std::string_view& text, std::uint32_t& address) {
  address = 0;
  for (int i = 0; i < 4; ++i) {
    if (i > 0) {
      if (text.empty() || text.front() != '.') return false;
      text.remove_prefix(1);
    }
    std::uint32_t part = 0;
    if (!take_number(text, 255, part)) return false;
    address = (address << 8) | part;
  }
  return true;
}

}  // namespace

Endpoint Endpoint::parse(std::string_view text) {
  std::string_view rest = text;
  Endpoint endpoint;
  std::uint32_t port = 0;
  if (take_address(rest, endpoint.address) && !rest.empty() && rest.front() == ':') {
    rest.remove_prefix(1);
    if (take_number(rest, 65535, port) && rest.empty()) {
      endpoint.port = static_cast<std::uint16_t>(port);
      return endpoint;
    }
  }
  throw StartupError("\"" + std::string(text) + "\" is not an endpoint; write it like 192.168.90.13:50013");
}

std::uint32_t Endpoint::parse_address(std::string_view text) {
  std::string_view rest = text;
  std::uint32_t address = 0;
  if (take_address(rest, address) && rest.empty()) return address;
  throw StartupError("\"" + std::string(text) + "\" is not an IPv4 address; write it like 192.168.90.13");
}

std::string address_to_string(std::uint32_t address) {
  return std::to_string(address >> 24) + '.' + std::to_string((address >> 16) & 255) + '.' +
         std::to_string((address >> 8) & 255) + '.' + std::to_string(address & 255);
}

std::string to_string(const Endpoint& endpoint) {
  return address_to_string(endpoint.address) + ':' + std::to_string(endpoint.port);
}

}  // namespace motionlab
