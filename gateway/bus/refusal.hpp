/// @file  Why an incoming sample is not handed on.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace motionlab::bus {

enum class Refusal : std::uint8_t {
  none,
  malformed,  ///< too short, wrong encapsulation, a boolean that is neither 0 nor 1, a text without its end
  text_too_long,  ///< longer than the IDL's bound
  unknown_enum,   ///< a number that is no enumerator
  not_finite,     ///< a NaN or infinity where TopicTraits<T>::may_be_nan does not allow it
  count_
};

[[nodiscard]] constexpr std::string_view to_string(Refusal refusal) noexcept {
  constexpr std::array<std::string_view, static_cast<std::size_t>(Refusal::count_)> kNames{
      "none", "malformed", "text_too_long", "unknown_enum", "not_finite"};
  const auto index = static_cast<std::size_t>(refusal);
  return index < kNames.size() ? kNames[index] : std::string_view{"?"};
}

}  // namespace motionlab::bus
