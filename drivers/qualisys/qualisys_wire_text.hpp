/// @file  Words and numbers of the protocol's ASCII text.
#pragma once

#include <algorithm>
#include <charconv>
#include <optional>
#include <string_view>

namespace motionlab::qualisys {

[[nodiscard]] constexpr char lower(char c) noexcept {
  return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}

/// Names are compared without regard to (ASCII) case, as people type them.
[[nodiscard]] constexpr bool same_name(std::string_view a, std::string_view b) noexcept {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](char x, char y) { return lower(x) == lower(y); });
}

/// What follows `prefix` in the word, if it begins so, in any case of letters.
[[nodiscard]] constexpr std::optional<std::string_view> after(std::string_view prefix,
                                                              std::string_view word) noexcept {
  if (!same_name(word.substr(0, prefix.size()), prefix)) return std::nullopt;
  return word.substr(prefix.size());
}

/// The number that is the whole text.
template <class Number>
[[nodiscard]] std::optional<Number> number(std::string_view text) noexcept {
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

/// Cuts a text into words at blanks, however many there are.
class Words {
 public:
  explicit constexpr Words(std::string_view text) noexcept : rest_(text) { skip(); }
  [[nodiscard]] constexpr bool empty() const noexcept { return rest_.empty(); }
  /// The next word; empty when there is none.
  constexpr std::string_view next() noexcept {
    const std::size_t end = std::min(rest_.find_first_of(kBlanks), rest_.size());
    const std::string_view word = rest_.substr(0, end);
    rest_.remove_prefix(end);
    skip();
    return word;
  }
  /// All that is left, without the blanks at its end.
  [[nodiscard]] constexpr std::string_view rest() const noexcept {
    return rest_.substr(0, rest_.find_last_not_of(kBlanks) + 1);
  }

 private:
  static constexpr std::string_view kBlanks = " \t\r\n";
  constexpr void skip() noexcept {
    rest_.remove_prefix(std::min(rest_.find_first_not_of(kBlanks), rest_.size()));
  }
  std::string_view rest_;
};

}  // namespace motionlab::qualisys
