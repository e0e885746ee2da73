#include "gateway/monitor/safe_text.hpp"

#include <array>
#include <cstdint>
#include <cstdio>

namespace motionlab::monitor {
namespace {

/// One character of UTF-8; a size of 0 for bytes that are none.
struct Character {
  std::uint32_t code = 0;
  std::size_t size = 0;
};

Character first_of(std::string_view text) {
  const auto byte = [&text](std::size_t i) { return static_cast<std::uint8_t>(text[i]); };
  const std::uint8_t lead = byte(0);
  if (lead < 0x80) return {lead, 1};
  const std::size_t size = lead >= 0xF0 && lead < 0xF5 ? 4 : lead >= 0xE0 && lead < 0xF0 ? 3 : 2;
  if (lead < 0xC2 || lead >= 0xF5 || text.size() < size) return {};
  std::uint32_t code = lead & (0xFFu >> (size + 1));
  for (std::size_t i = 1; i < size; ++i) {
    if ((byte(i) & 0xC0) != 0x80) return {};
    code = (code << 6) | (byte(i) & 0x3Fu);
  }
  constexpr std::array<std::uint32_t, 5> kSmallest{0, 0, 0x80, 0x800, 0x10000};
  const bool surrogate = code >= 0xD800 && code < 0xE000;
  if (code < kSmallest[size] || code > 0x10FFFF || surrogate) return {};
  return {code, size};
}

bool is_harmless(std::uint32_t code) {
  if (code < 0x20 || (code >= 0x7F && code < 0xA0)) return false;
  const bool turns = code == 0x61C || code == 0x200E || code == 0x200F ||
                     (code >= 0x2028 && code <= 0x202E) || (code >= 0x2066 && code <= 0x2069);
  return !turns && code != 0xFEFF;
}

std::string printed(const char* format, unsigned number) {
  std::array<char, 16> text{};
  std::snprintf(text.data(), text.size(), format, number);
  return text.data();
}

}  // namespace

std::string escaped(std::string_view text) {
  std::string safe;
  safe.reserve(text.size());
  while (!text.empty()) {
    const Character character = first_of(text);
    if (character.size == 0) {
      safe += printed("\\x%02x", static_cast<std::uint8_t>(text.front()));
      text.remove_prefix(1);
      continue;
    }
    if (character.code == '\\') {
      safe += "\\\\";
    } else if (character.code == '\n') {
      safe += "\\n";
    } else if (character.code == '\t') {
      safe += "\\t";
    } else if (is_harmless(character.code)) {
      safe += text.substr(0, character.size);
    } else if (character.code < 0x80) {
      safe += printed("\\x%02x", character.code);
    } else {
      safe += printed("\\u{%x}", character.code);
    }
    text.remove_prefix(character.size);
  }
  return safe;
}

}  // namespace motionlab::monitor
