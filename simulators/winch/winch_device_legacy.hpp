/// @file  The laboratory's published PLC project, as far as a client can see it: MAIN.winch in front of the
/// same drive.
#pragma once

#include <array>
#include <cstdint>

#include "drivers/core/bytes.hpp"
#include "drivers/core/time.hpp"
#include "drivers/winch/winch_wire.hpp"
#include "simulators/winch/winch_device_plc.hpp"

namespace motionlab::winch {

/// The variables of MAIN.winch and the program behind them.
///
/// As published it has no watchdog: the velocity that was written last is obeyed for ever. Modes local and
/// motion_compensation obey `u`, remote obeys `uRemote`, settled holds. bActive says that the velocity
/// changed in the last second. Reset is not wired: a drive fault stays until bEnable falls.
class LegacyProgram {
 public:
  explicit LegacyProgram(const PlcConfig& config) : config_(config) {}

  /// Before the drive's cycle: what the variables ask for becomes the drive's command.
  void command(LabTime t, PlcProgram& drive);
  /// After it: the variables tell what the drive did.
  void report(const PlcProgram& drive);

  [[nodiscard]] MutableBytes memory() noexcept { return memory_; }

 private:
  [[nodiscard]] LegacyCommand wanted();

  PlcConfig config_;
  std::array<std::uint8_t, kLegacyMemorySize> memory_{};
  std::uint32_t heartbeat_ = 0;
  double velocity_before_mps_ = 0;
  double measured_before_mps_ = 0;
  LabTime t_changed_{};
  LabTime t_{};
};

}  // namespace motionlab::winch
