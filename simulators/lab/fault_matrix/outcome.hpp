/// @file  What happened in a cell of the fault matrix.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace motionlab::matrix {

/// How it ended.
enum class Ending {
  rests,           ///< the engagement ended, latched, and everything came to rest
  rides_through,   ///< engaged all the time, and rightly so or unnoticed: the swing tells
  refuses,         ///< settled, and engaging was refused while the fault lasted
  engages,         ///< settled, and engaging was granted in spite of it
  brakes_engaged,  ///< the mode says engaged, but what is sent lets go of the arm
  not_stoppable,   ///< the arm goes on when the gateway has let go: it runs to the edge of its box
  cannot_be,       ///< the device or its wire refuses this fault; `code` says why
};

/// The most that a limit was ever exceeded by: by the commands, which are the datagrams on the arm's wire and
/// what the winch's driver is told, and by the plant.
struct Overshoot {
  double joint_position_rad = 0;  ///< the plant's, beyond the guard's box; 0: never
  double wire_length_m = 0;       ///< likewise
  /// The largest shares of a limit that a command had, 1 at the limit.
  double joint_speed = 0;
  double joint_acceleration = 0;
  double wire_speed = 0;
  double wire_acceleration = 0;
  /// Likewise of the plant. Its servos ring: at a set point that keeps the limit they may pass it.
  double plant_joint_speed = 0;
  double plant_wire_speed = 0;
  /// The plant's speed as a share of the most that its servo makes of set points within the limit
  /// (servo_speed_share): above 1 it was moved by something else than our commands.
  double plant_joint_speed_of_servo = 0;
  double plant_wire_speed_of_servo = 0;

  bool operator==(const Overshoot&) const = default;

  /// Which limit was exceeded, for people; empty: none. A joint that stops at the edge of its box overshoots
  /// a little (2 mrad), the wire likewise (5 mm).
  [[nodiscard]] std::string worst() const;
};

struct Outcome {
  bool in_state = false;  ///< ready or engaged, as the cell asks, when the fault came
  Ending ending = Ending::rides_through;
  std::string code;                        ///< that was latched, or for which it was refused
  std::optional<double> detected_after_s;  ///< the first that anybody could have seen; nothing: never
  std::string detected_by;                 ///< see CellWatch
  std::optional<double> at_rest_after_s;   ///< when arm and winch truly rested, if the engagement ended
  double swing_max_deg = 0;                ///< from the fault to the end of the run
  double swing_rms_deg = 0;                ///< while the fault lasted
  double twin_swing_max_deg = 0;           ///< of the uncontrolled twin, as the maximum
  double joint_speed_max_radps = 0;        ///< of the plant since the gateway let go
  Overshoot overshoot;
  bool advised = false;          ///< the device's health had a sentence of advice when the fault ended
  bool moved_by_itself = false;  ///< moved while settled or after it had rested, or engaged unasked

  bool operator==(const Outcome&) const = default;
};

[[nodiscard]] std::string_view to_string(Ending ending);
/// @returns nothing for a text that no ending has
[[nodiscard]] std::optional<Ending> ending_of(std::string_view text);

}  // namespace motionlab::matrix
