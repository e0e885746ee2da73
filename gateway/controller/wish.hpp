/// @file  What a controller wishes. Only the guard turns it into a command.
#pragma once

#include <array>

namespace motionlab::controller {

struct Wish {
  std::array<double, 6> qd_radps{};
  double wire_speed_mps = 0;  ///< + pays out
};

}  // namespace motionlab::controller
