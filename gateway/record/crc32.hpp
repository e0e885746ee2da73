/// @file  CRC-32 as MCAP, zip and Ethernet have it (polynomial 0x04C11DB7, reflected).
#pragma once

#include <cstdint>

#include "drivers/core/bytes.hpp"

namespace motionlab::record {

/// Goes on from `crc`, the result for the bytes before; 0 at first. Allocates nothing.
[[nodiscard]] std::uint32_t crc32(Bytes bytes, std::uint32_t crc = 0) noexcept;

}  // namespace motionlab::record
