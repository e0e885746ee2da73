/// @file  A topic's sample as JSON: the names of the IDL, in its order.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "gateway/monitor/sample_text.hpp"

namespace motionlab::monitor {

/// Enumerators become their names, NaN becomes null.
template <class T>
[[nodiscard]] nlohmann::ordered_json topic_json(const T& sample) {
  static const auto fields = select_fields(*topic_of_type(T::kTypeName), {});
  return as_json(fields, values_of(sample));
}

/// As text, in plain ASCII. Bytes from the network that are no UTF-8 are replaced.
[[nodiscard]] inline std::string json_text(const nlohmann::ordered_json& json) {
  return json.dump(2, ' ', true, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace motionlab::monitor
