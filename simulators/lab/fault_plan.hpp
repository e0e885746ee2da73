/// @file  Faults that are to happen at known times, written as on the command line.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace motionlab::lab {

/// One fault of one device.
struct PlannedFault {
  std::string device;             ///< mru1, mru2, qualisys, arm, winch, plc, world
  std::string fault;              ///< one of the device's own names
  double value = 0;               ///< its meaning is the fault's; 0: its default
  double from_s = 0;              ///< since the scenario began
  std::optional<double> until_s;  ///< nothing: for ever

  /// Parses `DEVICE:FAULT[=VALUE]@FROM[..UNTIL]`, times in s since the scenario began: "mru1:silent@12",
  /// "qualisys:loss=0.3@5..8", "qualisys:occlude:load@20..22", "world:gust:90=50@40..40.5".
  /// @throws StartupError that names the text and shows the wanted form
  static PlannedFault parse(std::string_view text);
};

}  // namespace motionlab::lab
