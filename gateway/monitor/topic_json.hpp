/// @file  A topic's sample as JSON: the names of the IDL, in its order.
#pragma once

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <type_traits>

#include "drivers/core/text.hpp"

namespace motionlab::monitor {

namespace detail {

template <class Value>
nlohmann::ordered_json json_of(const Value& value) {
  if constexpr (std::is_enum_v<Value>) {
    return std::string{to_string(value)};
  } else {
    return value;  // NaN becomes null
  }
}

template <std::size_t N>
nlohmann::ordered_json json_of(const Text<N>& text) {
  return text.str();
}

}  // namespace detail

/// Enumerators become their names, NaN becomes null.
template <class T>
[[nodiscard]] nlohmann::ordered_json topic_json(const T& sample) {
  nlohmann::ordered_json json;
  T::fields(sample, [&json](std::string_view name, const auto& value) {
    json[std::string{name}] = detail::json_of(value);
  });
  return json;
}

/// As text. Bytes from the network that are no UTF-8 are replaced.
[[nodiscard]] inline std::string json_text(const nlohmann::ordered_json& json) {
  return json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace motionlab::monitor
