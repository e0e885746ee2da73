/// @file  A cell of the fault matrix: which fault, of what, in which state of the gateway, and when.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "simulators/lab/lab_config.hpp"

namespace motionlab::matrix {

/// What the gateway does when the fault comes.
enum class State {
  settled,  ///< nothing is engaged while the ship moves; somebody asks to engage while the fault lasts
  calm,     ///< engaged, the ship rests
  sea       ///< engaged, the ship moves
};
inline constexpr State kStates[] = {State::settled, State::calm, State::sea};

/// Which program the robot computer runs.
enum class Program {
  hardened,  ///< with a watchdog of its own
  faithful   ///< the laboratory's, with its published defects; the gateway then knows that there is no
             ///< watchdog
};

/// One fault of one device, or of its wire.
struct DeviceFault {
  std::string device;
  std::string name;
  Program program = Program::hardened;

  bool operator==(const DeviceFault&) const = default;
};

struct Cell {
  DeviceFault fault;
  State state = State::settled;

  [[nodiscard]] std::string title() const;
  bool operator==(const Cell&) const = default;
};

[[nodiscard]] std::string_view to_string(State state);
[[nodiscard]] std::string_view to_string(Program program);

/// Whether the robot computer is given bytes that we did not send, and executes them: the published program
/// checks neither its sender nor what arrives.
[[nodiscard]] bool obeys_others(const DeviceFault& fault);

/// A fault by name, and whether the device can have it.
struct KnownFault {
  DeviceFault fault;
  std::string refusal;  ///< why it cannot be: the sentence that the device or its wire gives; empty: it can
};

/// Every fault of the house's words and of each device's own, for every device of this laboratory and its
/// wire, in their own order. Each is tried: whoever refuses one says why. Those of the robot computer come
/// for both of its programs.
[[nodiscard]] std::vector<KnownFault> every_fault(const lab::LabConfig& config);

/// When what happens, in s since the start.
struct Timetable {
  double engage_s;      ///< somebody asks to engage
  double fault_s;       ///< the fault begins ...
  double fault_ends_s;  ///< ... and ends
  double end_s;         ///< of the run

  /// Cameras are coasted over for 10 s, and an arm that nobody stops takes as long to the edge of its box:
  /// theirs last longer than the 5 s of the others.
  [[nodiscard]] static Timetable of(const Cell& cell);
};

}  // namespace motionlab::matrix
