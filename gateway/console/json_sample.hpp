/// @file  A topic's sample from JSON: the names of the IDL, whichever they are.
#pragma once

#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>

#include "drivers/core/text.hpp"

namespace motionlab::console {

namespace detail {

[[noreturn]] inline void wrong(std::string_view name, const std::string& what) {
  throw std::invalid_argument{std::string{name} + " " + what};
}

template <class Value>
void from_json(std::string_view name, const nlohmann::json& json, Value& value) {
  if constexpr (std::is_enum_v<Value>) {
    if (!json.is_string()) wrong(name, "is no name of a choice");
    const std::string wanted = json.get<std::string>();
    std::uint32_t number = 0;
    std::string choices;
    for (; to_string(static_cast<Value>(number)) != "?"; ++number) {
      if (to_string(static_cast<Value>(number)) == wanted) break;
      choices += (choices.empty() ? "" : ", ") + std::string{to_string(static_cast<Value>(number))};
    }
    value = static_cast<Value>(number);
    if (to_string(value) == "?") wrong(name, "is none of " + choices);
  } else if constexpr (std::is_same_v<Value, bool>) {
    if (!json.is_boolean()) wrong(name, "is neither true nor false");
    value = json.get<bool>();
  } else if constexpr (std::is_floating_point_v<Value>) {
    if (!json.is_number()) wrong(name, "is no number");
    value = json.get<Value>();
    if (!std::isfinite(value)) wrong(name, "is not finite");
  } else {
    if (!json.is_number_integer()) wrong(name, "is no whole number");
    const bool negative =
        json.is_number_integer() && !json.is_number_unsigned() && json.get<std::int64_t>() < 0;
    if (negative
            ? std::is_unsigned_v<Value> ||
                  json.get<std::int64_t>() < static_cast<std::int64_t>(std::numeric_limits<Value>::min())
            : json.get<std::uint64_t>() > static_cast<std::uint64_t>(std::numeric_limits<Value>::max())) {
      wrong(name, "is out of its range");
    }
    value = json.get<Value>();
  }
}

template <std::size_t N>
void from_json(std::string_view name, const nlohmann::json& json, Text<N>& text) {
  if (!json.is_string()) wrong(name, "is no text");
  const std::string given = json.get<std::string>();
  if (given.size() > N) wrong(name, "has more than " + std::to_string(N) + " characters");
  text.assign(given);
}

template <class Value, std::size_t N>
void from_json(std::string_view name, const nlohmann::json& json, std::array<Value, N>& values) {
  if (!json.is_array() || json.size() != N) wrong(name, "is no list of " + std::to_string(N));
  for (std::size_t i = 0; i < N; ++i) from_json(name, json[i], values[i]);
}

}  // namespace detail

/// Fills the fields that the JSON names; the others stay as they are.
/// @throws std::invalid_argument  with a sentence: no object, an unknown name, a value of another kind
template <class T>
void fill_from_json(const nlohmann::json& json, T& sample) {
  if (!json.is_object()) throw std::invalid_argument{"the message is no JSON object"};
  std::size_t used = 0;
  std::string names;
  T::fields(sample, [&](std::string_view name, auto& value) {
    names += (names.empty() ? "" : ", ") + std::string{name};
    const auto found = json.find(std::string{name});
    if (found == json.end()) return;
    detail::from_json(name, *found, value);
    ++used;
  });
  if (used != json.size()) throw std::invalid_argument{"there are only " + names};
}

}  // namespace motionlab::console
