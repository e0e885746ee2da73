#include "gateway/monitor/sample_text.hpp"

#include <array>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <type_traits>

#include "gateway/monitor/safe_text.hpp"

namespace motionlab::monitor {
namespace {

template <class... F>
struct Overloaded : F... {
  using F::operator()...;
};

std::string not_finite(double value) {
  return std::isnan(value) ? "NaN" : value > 0 ? "Inf" : "-Inf";
}

/// The shortest text that reads back as the same number.
std::string exact(double value) {
  if (!std::isfinite(value)) return not_finite(value);
  std::array<char, 32> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
  return {text.data(), end};
}

std::string six_digits(double value) {
  if (!std::isfinite(value)) return not_finite(value);
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.6g", value);
  return text.data();
}

std::string for_people(const Value& value) {
  return std::visit(Overloaded{[](bool yes) -> std::string { return yes ? "true" : "false"; },
                               [](std::int64_t number) { return std::to_string(number); },
                               [](std::uint64_t number) { return std::to_string(number); },
                               [](double number) { return six_digits(number); },
                               [](const std::string& text) { return escaped(text); }},
                    value);
}

/// A stamp of laboratory time in real time; a lockstep run begins at zero and shows none.
std::string time_of_day(std::int64_t ns) {
  constexpr std::int64_t kYear2000 = 946'684'800;
  const std::time_t second = ns / 1'000'000'000;
  std::tm utc{};
  if (second < kYear2000 || gmtime_r(&second, &utc) == nullptr) return {};
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "  (%02d:%02d:%02d.%06lld UTC)", utc.tm_hour, utc.tm_min,
                utc.tm_sec, static_cast<long long>(ns % 1'000'000'000 / 1000));
  return text.data();
}

std::string field_for_people(const Selected& field, const Values& values) {
  if (!field.is_array) return for_people(values[field.first]);
  std::string text = "[";
  for (std::size_t i = 0; i < field.count; ++i)
    text += (i > 0 ? ", " : "") + for_people(values[field.first + i]);
  return text + "]";
}

nlohmann::ordered_json json_value(const Value& value) {
  return std::visit([](const auto& one) { return nlohmann::ordered_json(one); },
                    value);  // NaN is dumped as null
}

std::string csv_text(const std::string& text) {
  const std::string safe = escaped(text);
  if (safe.find_first_of(",\"") == std::string::npos) return safe;
  std::string quoted = "\"";
  for (const char character : safe) {
    if (character == '"') quoted += '"';
    quoted += character;
  }
  return quoted + "\"";
}

std::string csv_value(const Value& value) {
  return std::visit(Overloaded{[](bool yes) -> std::string { return yes ? "1" : "0"; },
                               [](std::int64_t number) { return std::to_string(number); },
                               [](std::uint64_t number) { return std::to_string(number); },
                               [](double number) { return exact(number); },
                               [](const std::string& text) { return csv_text(text); }},
                    value);
}

}  // namespace

std::string as_block(const std::vector<Selected>& fields, const Values& values) {
  std::size_t width = 0;
  for (const Selected& field : fields) width = std::max(width, field.path.size());
  std::string text;
  for (const Selected& field : fields) {
    text += field.path + std::string(width + 2 - field.path.size(), ' ') + field_for_people(field, values);
    const auto* const stamp = std::get_if<std::int64_t>(&values[field.first]);
    if (stamp && field.path.starts_with("t_") && field.path.ends_with("_ns")) text += time_of_day(*stamp);
    text += '\n';
  }
  return text + "---\n";
}

std::string as_line(const std::vector<Selected>& fields, const Values& values) {
  std::string text;
  for (const Selected& field : fields) {
    if (!text.empty()) text += "  ";
    text += field.path + " " + field_for_people(field, values);
  }
  return text + "\n";
}

nlohmann::ordered_json as_json(const std::vector<Selected>& fields, const Values& values) {
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  for (const Selected& field : fields) {
    if (field.is_array) {
      auto& array = json[field.path] = nlohmann::ordered_json::array();
      for (std::size_t i = 0; i < field.count; ++i) array.push_back(json_value(values[field.first + i]));
    } else {
      json[field.path] = json_value(values[field.first]);
    }
  }
  return json;
}

std::string as_json_line(const std::vector<Selected>& fields, const Values& values) {
  return as_json(fields, values).dump(-1, ' ', true, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

std::string csv_header(const std::vector<Selected>& fields) {
  std::string text;
  const auto column = [&text](const std::string& name) { text += (text.empty() ? "" : ",") + name; };
  for (const Selected& field : fields) {
    if (!field.is_array) column(field.path);
    for (std::size_t i = 0; field.is_array && i < field.count; ++i) {
      column(field.path + "[" + std::to_string(i) + "]");
    }
  }
  return text + "\n";
}

std::string as_csv(const std::vector<Selected>& fields, const Values& values) {
  std::string text;
  bool first = true;
  for (const Selected& field : fields) {
    for (std::size_t i = 0; i < field.count; ++i) {
      if (!first) text += ',';
      first = false;
      text += csv_value(values[field.first + i]);
    }
  }
  return text + "\n";
}

}  // namespace motionlab::monitor
