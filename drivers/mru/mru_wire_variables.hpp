/// @file  The variables that a Kongsberg Seatex MRU can be told to put into its output, and lists of them.
///
/// The list is the user's choice, so nothing here is a struct of the laboratory's datagram: a list of
/// variable numbers makes the layout. Source: the laboratory's MRU configuration (December 2017) and its
/// variable list.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "drivers/core/result.hpp"

namespace motionlab::mru {

/// Variable numbers as the maker counts them. Axes: R, P, Y are the unit's own (forward, starboard, down:
/// body frame); F, S, D are forward, starboard, down in the heading frame. "Cg" is the point to which the
/// unit refers its motion: in the laboratory the platform's origin (the unit applies that lever arm itself).
enum class Variable : std::uint16_t {
  ang_rate_r = 1,
  ang_rate_p = 2,
  ang_rate_y = 3,
  ang_rate_d = 9,
  sensor_temperature = 31,
  ang_acc_r = 60,
  ang_acc_p = 61,
  ang_acc_y = 62,
  roll = 63,
  pitch = 64,
  yaw = 65,
  system_time = 176,
  acc_mru_r = 238,
  acc_mru_p = 239,
  acc_mru_y = 240,
  vel_mru_r = 244,
  vel_mru_p = 245,
  vel_mru_y = 246,
  acc_cg_f = 250,
  acc_cg_s = 251,
  acc_cg_d = 252,
  vel_cg_f = 262,
  vel_cg_s = 263,
  vel_cg_d = 264,
  pos_cg_f = 274,
  pos_cg_s = 275,
  pos_cg_d = 276,
};

/// How a variable lies in its four bytes.
enum class ValueType : std::uint8_t { f32, i32 };

/// What a variable means physically; decides which plausibility limit holds for it.
enum class Quantity : std::uint8_t { time, temperature, tilt, heading, rate, motion, heave, unlisted };

struct VariableFacts {
  Variable variable{};
  std::string_view name;  ///< the maker's
  ValueType type{};
  Quantity quantity{};
  std::string_view unit;
  std::string_view frame;  ///< body, heading, or empty for what has none
};

/// What is known of a variable; nothing when its number is not in the table.
[[nodiscard]] const VariableFacts* facts_of(Variable variable) noexcept;

/// At most this many variables fit: the length byte counts 1 + 4 N.
inline constexpr std::size_t kMaxVariables = 63;

/// An ordered choice of variables. Trivially copyable; never allocates.
class VariableList {
 public:
  VariableList() = default;

  /// @param unlisted_f32, unlisted_i32  numbers that are not in the table, by the type of their four bytes:
  ///        they are read over and told nobody
  /// Faults: bad_value for an empty list, more than 63 variables, a number that is neither in the table nor
  /// said to be unlisted, or one twice.
  [[nodiscard]] static Result<VariableList> of(std::span<const Variable> variables,
                                               std::span<const Variable> unlisted_f32 = {},
                                               std::span<const Variable> unlisted_i32 = {}) noexcept;
  /// The 24 variables of the laboratory's 100-byte datagram.
  [[nodiscard]] static const VariableList& laboratory() noexcept;

  [[nodiscard]] std::size_t size() const noexcept { return size_; }
  /// @pre index < size()
  [[nodiscard]] const VariableFacts& operator[](std::size_t index) const noexcept { return facts_[index]; }
  /// Where a variable stands in the datagram, counted in values from 0; nothing when the list lacks it.
  [[nodiscard]] std::optional<std::size_t> index_of(Variable variable) const noexcept;

 private:
  std::array<VariableFacts, kMaxVariables> facts_{};
  std::size_t size_ = 0;
};

}  // namespace motionlab::mru
