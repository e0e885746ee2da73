/// @file  The PLC's axis position and the free length of wire.
#pragma once

namespace motionlab::winch {

/// wire_length_m = wire_at_zero_travel_m + pay_out_sign * (axis position); speeds and accelerations follow.
/// The mapping is made here and nowhere else.
struct AxisMap {
  double wire_at_zero_travel_m =
      1.20;                   ///< free wire length where the axis' position is zero; measure on site
  double pay_out_sign = 1.0;  ///< +1 or -1: which way the axis' position grows when wire is paid out

  [[nodiscard]] double position_m(double wire_length_m) const noexcept {
    return pay_out_sign * (wire_length_m - wire_at_zero_travel_m);
  }
  [[nodiscard]] double wire_length_m(double axis_position_m) const noexcept {
    return wire_at_zero_travel_m + pay_out_sign * axis_position_m;
  }
  /// A speed or an acceleration of the wire for the axis, or the other way round.
  [[nodiscard]] double turned(double rate) const noexcept { return pay_out_sign * rate; }
};

}  // namespace motionlab::winch
