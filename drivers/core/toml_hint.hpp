/// @file  What somebody who wrote an unknown key probably meant.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace motionlab {

/// The unit at the end of a key, in words: "seconds" of "period_s"; empty when it has none.
[[nodiscard]] std::string_view unit_of_key(std::string_view key) noexcept;

/// Whether two keys differ in nothing but their unit, e.g. "period_s" and "period_ms" or "period"; not
/// "noise_m" and "noise_rad", which are different quantities.
[[nodiscard]] bool differ_in_unit_only(std::string_view a, std::string_view b) noexcept;

/// The key of `known` that `written` was probably meant to be; nothing when none is close.
[[nodiscard]] std::optional<std::string> closest_key(std::string_view written,
                                                     const std::vector<std::string>& known);

}  // namespace motionlab
