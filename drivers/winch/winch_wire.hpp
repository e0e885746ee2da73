/// @file  The bytes between the gateway and the winch's PLC: AMS/TCP frames, ADS commands, the two PLC
/// structs. Pure: bytes in, values out, and back. Driver and simulated PLC share it. Everything is
/// little-endian.
#pragma once

#include "drivers/winch/winch_wire_ads.hpp"
#include "drivers/winch/winch_wire_ams.hpp"
#include "drivers/winch/winch_wire_errors.hpp"
#include "drivers/winch/winch_wire_filetime.hpp"
#include "drivers/winch/winch_wire_legacy.hpp"
#include "drivers/winch/winch_wire_notification.hpp"
#include "drivers/winch/winch_wire_structs.hpp"
#include "drivers/winch/winch_wire_symbols.hpp"
#include "drivers/winch/winch_wire_upload.hpp"
