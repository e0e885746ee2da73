/// @file  Which format does a stream have? For people who put a unit into service; the gateway binds one
/// format to a port by configuration and never guesses.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "drivers/core/bytes.hpp"
#include "drivers/mru/mru_wire_motion.hpp"

namespace motionlab::mru {

/// What one datagram looks like; nothing when it looks like none. Strongly marked formats are asked first:
/// EM3000 and EM1000 are told by one byte alone.
[[nodiscard]] std::optional<Format> looks_like(Bytes datagram) noexcept;

/// Watches a stream until it is sure.
class FormatDetector {
 public:
  /// Of a format that only one byte marks, so many datagrams are needed; of the others, so few.
  static constexpr std::uint64_t kNeededOfWeak = 20;
  static constexpr std::uint64_t kNeededOfStrong = 3;

  void take(Bytes datagram) noexcept;

  /// The format of more than nine tenths of the datagrams, once there are enough of them.
  [[nodiscard]] std::optional<Format> format() const noexcept;
  [[nodiscard]] std::uint64_t datagrams() const noexcept { return datagrams_; }
  [[nodiscard]] std::uint64_t count(Format format) const noexcept {
    return counts_[static_cast<std::size_t>(format)];
  }
  /// Bytes of the newest datagram.
  [[nodiscard]] std::size_t size() const noexcept { return size_; }
  /// Of MRUBIN and NMEAP: the token of the newest datagram that looked like it; nothing before.
  [[nodiscard]] std::optional<std::uint8_t> token() const noexcept { return token_; }
  /// How many variables that datagram has.
  [[nodiscard]] std::size_t variables() const noexcept { return variables_; }

 private:
  std::array<std::uint64_t, kFormats.size()> counts_{};
  std::uint64_t datagrams_ = 0;
  std::size_t size_ = 0;
  std::optional<std::uint8_t> token_;
  std::size_t variables_ = 0;
};

}  // namespace motionlab::mru
