/// @file  FILETIME, the PLC's calendar: 100 ns since 1601-01-01 UTC.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>

#include "drivers/core/time.hpp"

namespace motionlab::winch {

/// 1970-01-01 UTC as FILETIME.
inline constexpr std::uint64_t kFiletimeOf1970 = 116'444'736'000'000'000ULL;

/// Time since 1970 of a FILETIME; nothing before 1970 or after the year 2262, where nanoseconds end. Zero,
/// which a PLC that never set its stamp sends, is such a time.
[[nodiscard]] constexpr std::optional<Nanoseconds> since_1970(std::uint64_t filetime) noexcept {
  constexpr auto kLast = static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max()) / 100;
  if (filetime < kFiletimeOf1970 || filetime - kFiletimeOf1970 > kLast) return std::nullopt;
  return Nanoseconds{static_cast<std::int64_t>(filetime - kFiletimeOf1970) * 100};
}

/// FILETIME of a time since 1970, cut to 100 ns; times before 1970 become 1970.
[[nodiscard]] constexpr std::uint64_t to_filetime(Nanoseconds t_since_1970) noexcept {
  if (t_since_1970 < Nanoseconds{0}) return kFiletimeOf1970;
  return kFiletimeOf1970 + static_cast<std::uint64_t>(t_since_1970.count() / 100);
}

}  // namespace motionlab::winch
