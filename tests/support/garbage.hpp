/// @file  What a gateway may hear from anybody: bytes that mean nothing.
#pragma once

#include <cstdint>
#include <vector>

#include "drivers/core/random.hpp"

namespace motionlab::test {

/// Random bytes of random length; some begin as the device's own do. Always the same.
inline std::vector<std::vector<std::uint8_t>> garbage() {
  Random random(11);
  std::vector<std::vector<std::uint8_t>> all(997);
  for (auto& datagram : all) {
    datagram.resize(random.below(300));
    for (auto& byte : datagram) byte = static_cast<std::uint8_t>(random.bits());
    if (datagram.size() > 1 && random.chance(0.2)) datagram[0] = 'q';  // an MRU's header
    if (datagram.size() == 52) datagram[0] = 32;                       // a robot computer's key
  }
  return all;
}

}  // namespace motionlab::test
