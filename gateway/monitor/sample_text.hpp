/// @file  A sample as text for people, as one line of JSON, as one row of CSV. Works on any topic's `Values`.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "gateway/monitor/field_selection.hpp"
#include "gateway/monitor/topic_table.hpp"

namespace motionlab::monitor {

/// One line for each field, "name  value", numbers to six digits, stamps with their UTC time of day; "---" at
/// the end.
[[nodiscard]] std::string as_block(const std::vector<Selected>& fields, const Values& values);

/// The same fields in one line: "swing_rad [0.01, -0.002]  wire_length_m 2.001".
[[nodiscard]] std::string as_line(const std::vector<Selected>& fields, const Values& values);

/// One JSON object with the fields by their paths. Numbers keep every digit; what is not finite is null.
[[nodiscard]] nlohmann::ordered_json as_json(const std::vector<Selected>& fields, const Values& values);
/// The same as one line of plain ASCII; bytes that are no UTF-8 are replaced.
[[nodiscard]] std::string as_json_line(const std::vector<Selected>& fields, const Values& values);

/// The names of the columns: one for each element of an array.
[[nodiscard]] std::string csv_header(const std::vector<Selected>& fields);
/// Numbers keep every digit; NaN, Inf and -Inf are written so; texts are quoted where RFC 4180 asks for it,
/// and their control characters escaped, so that one sample is one line.
[[nodiscard]] std::string as_csv(const std::vector<Selected>& fields, const Values& values);

}  // namespace motionlab::monitor
