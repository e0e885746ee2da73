#include "drivers/core/toml_hint.hpp"

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <utility>

namespace motionlab {
namespace {

enum class Quantity {
  none,
  time,
  frequency,
  length,
  angle,
  speed,
  acceleration,
  turn_rate,
  turn_acceleration,
  mass,
  force,
  torque,
  stiffness,
  power,
  share,
  memory,
};

struct Unit {
  std::string_view suffix;
  std::string_view words;
  Quantity quantity;
};

constexpr Unit kUnits[] = {
    {"s", "seconds", Quantity::time},
    {"ms", "milliseconds", Quantity::time},
    {"us", "microseconds", Quantity::time},
    {"ns", "nanoseconds", Quantity::time},
    {"min", "minutes", Quantity::time},
    {"h", "hours", Quantity::time},
    {"hz", "hertz", Quantity::frequency},
    {"khz", "kilohertz", Quantity::frequency},
    {"m", "metres", Quantity::length},
    {"mm", "millimetres", Quantity::length},
    {"cm", "centimetres", Quantity::length},
    {"km", "kilometres", Quantity::length},
    {"rad", "radians", Quantity::angle},
    {"mrad", "milliradians", Quantity::angle},
    {"deg", "degrees", Quantity::angle},
    {"mps", "metres per second", Quantity::speed},
    {"mmps", "millimetres per second", Quantity::speed},
    {"mps2", "metres per second squared", Quantity::acceleration},
    {"radps", "radians per second", Quantity::turn_rate},
    {"radps2", "radians per second squared", Quantity::turn_acceleration},
    {"degps", "degrees per second", Quantity::turn_rate},
    {"degps2", "degrees per second squared", Quantity::turn_acceleration},
    {"rpm", "revolutions per minute", Quantity::turn_rate},
    {"kg", "kilograms", Quantity::mass},
    {"g", "grams", Quantity::mass},
    {"n", "newtons", Quantity::force},
    {"kn", "kilonewtons", Quantity::force},
    {"nm", "newton metres", Quantity::torque},
    {"npm", "newtons per metre", Quantity::stiffness},
    {"w", "watts", Quantity::power},
    {"ppm", "parts per million", Quantity::share},
    {"percent", "percent", Quantity::share},
    {"ratio", "a ratio", Quantity::share},
    {"bytes", "bytes", Quantity::memory},
    {"kib", "kibibytes", Quantity::memory},
};

struct Parts {
  std::string_view stem;
  std::string_view unit;  ///< in words; empty when there is none
  Quantity quantity = Quantity::none;
};

Parts split(std::string_view key) noexcept {
  const std::size_t bar = key.rfind('_');
  if (bar != std::string_view::npos && bar > 0) {
    for (const Unit& unit : kUnits) {
      if (key.substr(bar + 1) == unit.suffix) return {key.substr(0, bar), unit.words, unit.quantity};
    }
  }
  return {key, {}, Quantity::none};
}

/// Levenshtein: how many characters to insert, delete or replace.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = std::exchange(row[0], i);
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replace = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = std::exchange(row[j], std::min({row[j] + 1, row[j - 1] + 1, replace}));
    }
  }
  return row.back();
}

}  // namespace

std::string_view unit_of_key(std::string_view key) noexcept {
  return split(key).unit;
}

bool differ_in_unit_only(std::string_view a, std::string_view b) noexcept {
  const Parts parts_a = split(a);
  const Parts parts_b = split(b);
  const bool may_be_the_same = parts_a.quantity == parts_b.quantity || parts_a.quantity == Quantity::none ||
                               parts_b.quantity == Quantity::none;
  return a != b && parts_a.stem == parts_b.stem && may_be_the_same;
}

std::optional<std::string> closest_key(std::string_view written, const std::vector<std::string>& known) {
  const std::string* best = nullptr;
  std::size_t best_distance = std::max<std::size_t>(2, written.size() / 3) + 1;
  for (const std::string& candidate : known) {
    const std::size_t distance =
        differ_in_unit_only(written, candidate) ? 0 : edit_distance(written, candidate);
    if (distance < best_distance) {
      best = &candidate;
      best_distance = distance;
    }
  }
  if (!best) return std::nullopt;
  return *best;
}

}  // namespace motionlab
