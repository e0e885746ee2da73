/// @file  Faults that more than one part of the driver names.
#pragma once

#include "drivers/core/result.hpp"

namespace motionlab::qualisys {

inline constexpr Fault kWrongCount{
    Reason::bad_value, "frames hold another number of bodies than QTM's list: reading the list again"};

}  // namespace motionlab::qualisys
