/// @file  What every format of a motion reference unit is turned into: one internal form, SI and radians, and
/// the conversions of sign, unit and roll type that lead there.
#pragma once

#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <optional>
#include <string_view>

#include "drivers/core/result.hpp"
#include "drivers/core/time.hpp"
#include "drivers/mru/mru_wire.hpp"

namespace motionlab::mru {

/// The output protocols that are understood, by the names that the configuration uses.
enum class Format : std::uint8_t {
  mrubin,     ///< "MRU normal": any list of variables
  km_binary,  ///< `#KMB`
  em3000,     ///< Simrad EM3000 attitude, Euler roll, with status
  em1000,     ///< the same bytes without status, Hippy roll
  tss1,       ///< one line of text, Hippy roll
  psxn,       ///< `$PSXN,20` to `,24`
  prdid,      ///< `$PRDID`: attitude alone
  bin23,      ///< Seapath binary 23
  nmeap,      ///< `$PSXN,10` and `,11`: any list of variables, as text
};

inline constexpr std::array<std::string_view, 9> kFormatNames{
    "mrubin", "km_binary", "em3000", "em1000", "tss1", "psxn", "prdid", "bin23", "nmeap"};
inline constexpr std::array kFormats{Format::mrubin, Format::km_binary, Format::em3000,
                                     Format::em1000, Format::tss1,      Format::psxn,
                                     Format::prdid,  Format::bin23,     Format::nmeap};

/// Whether the user of the unit has chosen a token and a list of variables.
[[nodiscard]] constexpr bool has_list(Format format) noexcept {
  return format == Format::mrubin || format == Format::nmeap;
}

[[nodiscard]] constexpr std::string_view to_string(Format format) noexcept {
  return kFormatNames[static_cast<std::size_t>(format)];
}

inline constexpr double kNotTold = std::numeric_limits<double>::quiet_NaN();
inline constexpr double kDegree = std::numbers::pi / 180.0;

/// The unit's own clock: since power-on or since 1970, as the format has it.
struct UnitTime {
  std::uint32_t ms = 0;      ///< modulo 2^32
  Nanoseconds within_ms{0};  ///< what is finer, in [0, 1 ms)

  [[nodiscard]] static constexpr UnitTime of(Nanoseconds t) noexcept {
    const auto ms = std::chrono::floor<std::chrono::milliseconds>(t);
    return {static_cast<std::uint32_t>(ms.count()), t - ms};
  }
};

/// One measurement. Roll + port up and pitch + bow up are Euler angles; everything vertical is + down; rates
/// are about the unit's own axes (forward, starboard, down); "heading" is the horizontal frame turned with
/// the heading; "origin" is the point to which the unit was told to refer its motion. NaN: the format does
/// not carry it, or the unit itself calls it invalid.
struct Motion {
  using Triple = std::array<double, 3>;
  static constexpr Triple kNothing{kNotTold, kNotTold, kNotTold};

  bool stable = true;    ///< the unit stands by its attitude and heave: not settling, not invalid
  bool reduced = false;  ///< the unit says that something is less accurate than usual
  std::optional<UnitTime> t_unit{};
  Triple euler_heading_mru_rad = kNothing;  ///< roll, pitch, yaw in (-pi, pi]
  Triple omega_mru_radps = kNothing;
  double omega_down_radps = kNotTold;
  Triple v_mru_mps = kNothing;
  Triple a_mru_mps2 = kNothing;
  Triple p_heading_origin_m = kNothing;
  Triple v_heading_origin_mps = kNothing;
  Triple a_heading_origin_mps2 = kNothing;
  double sensor_temperature_degc = kNotTold;
};

/// How a datagram's own checksum came out.
struct Check {
  enum class Rule : std::uint8_t {
    none,       ///< the datagram carries none
    known,      ///< the format says how it is made: `good` tells
    unsettled,  ///< MRUBIN: `match` tells which of the possible rules agree
  };
  Rule rule = Rule::none;
  bool good = true;
  ChecksumMatch match{};
};

/// What one datagram says.
struct Telegram {
  Motion motion;
  Check check;
};

/// Roll as Hippy and TSS instruments mean it, the angle of the athwartships axis against the horizon:
/// sin(hippy) = sin(euler) cos(pitch).
[[nodiscard]] double hippy_roll(double euler_roll_rad, double pitch_rad) noexcept;
/// The inverse; NaN where no Euler roll gives this Hippy roll at this pitch.
[[nodiscard]] double euler_roll(double hippy_roll_rad, double pitch_rad) noexcept;

/// A compass heading in degrees, 0 to 360, as yaw in (-pi, pi].
[[nodiscard]] double yaw_of_heading(double heading_deg) noexcept;
/// The inverse, in [0, 360).
[[nodiscard]] double heading_of_yaw(double yaw_rad) noexcept;

/// A vector of the north, east, down frame in the heading frame. NaN where the yaw is not known.
[[nodiscard]] Motion::Triple heading_from_ned(const Motion::Triple& ned, double yaw_rad) noexcept;
/// The inverse.
[[nodiscard]] Motion::Triple ned_from_heading(const Motion::Triple& heading, double yaw_rad) noexcept;

/// A value in counts of `unit`, rounded. NaN and what does not fit become the greatest count, which in every
/// format here is beyond what a unit can mean.
template <class Count>
[[nodiscard]] Count to_counts(double value, double unit) noexcept {
  constexpr Count most = std::numeric_limits<Count>::max();
  const double counts = std::round(value / unit);
  const bool fits = counts >= std::numeric_limits<Count>::min() && counts <= static_cast<double>(most);
  return fits ? static_cast<Count>(counts) : most;
}

/// Whether a platform can move so. What is NaN has not been told and is not judged, attitude excepted: every
/// format carries it, so its absence is a fault.
/// @returns bad_value with a text that names the quantity
[[nodiscard]] Status check_plausible(const Motion& motion, const PlausibilityLimits& limits) noexcept;

}  // namespace motionlab::mru
