/// @file  From the PLC's status to the neutral sample.
#pragma once

#include "drivers/core/time.hpp"
#include "drivers/winch/winch_driver_axis.hpp"
#include "drivers/winch/winch_wire.hpp"
#include "idl/winch_state.hpp"

namespace motionlab::winch {

/// Everything of the sample that the status knows. Device, sequence number, stamps and command_path_alive are
/// the caller's.
[[nodiscard]] topic::WinchState to_state(const PlcStatus& status, const AxisMap& axis) noexcept;

/// The laboratory's published project in the words of ours. It has neither stamp nor heartbeat nor limits:
/// the caller gives what it knows; torque and temperature are NaN.
/// @param t_asked  when the values were asked for; they are not older
/// @param heartbeat_echo  the newest command that was acknowledged
[[nodiscard]] PlcStatus from_legacy(const LegacyStatus& status, LabTime t_asked, std::uint32_t heartbeat_echo,
                                    double travel_m) noexcept;

}  // namespace motionlab::winch
