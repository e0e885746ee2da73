/// @file  The name that DDS gives to a participant, writer or reader.
#pragma once

#include <array>
#include <compare>
#include <cstdint>

namespace motionlab::bus {

/// Unique on the bus.
struct DdsId {
  std::array<std::uint8_t, 16> bytes{};
  auto operator<=>(const DdsId&) const = default;
};

}  // namespace motionlab::bus
