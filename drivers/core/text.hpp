/// @file  `Text<N>`: a short text by value, for topics and hand-over between threads. Never allocates.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <string>
#include <string_view>

namespace motionlab {

/// At most N characters; longer input is cut. Trivially copyable. Empty at birth.
template <std::size_t N>
class Text {
 public:
  static constexpr std::size_t kCapacity = N;

  constexpr Text() = default;
  constexpr Text(std::string_view text) noexcept { assign(text); }
  constexpr Text(const char* text) noexcept : Text(std::string_view{text}) {}
  Text(const std::string& text) noexcept : Text(std::string_view{text}) {}

  constexpr void assign(std::string_view text) noexcept {
    characters_.fill('\0');
    std::copy_n(text.begin(), std::min(text.size(), N), characters_.begin());
  }

  [[nodiscard]] constexpr std::string_view view() const noexcept {
    const std::string_view all{characters_.data(), N};
    return all.substr(0, all.find('\0'));
  }
  constexpr operator std::string_view() const noexcept { return view(); }
  [[nodiscard]] std::string str() const { return std::string{view()}; }
  [[nodiscard]] constexpr bool empty() const noexcept { return characters_[0] == '\0'; }

  constexpr bool operator==(const Text&) const = default;

 private:
  std::array<char, N> characters_{};
};

}  // namespace motionlab
