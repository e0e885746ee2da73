/// @file  What the gateway believes of how a servo follows its set point.
#pragma once

namespace motionlab::controller {

/// Second-order lag behind a pure delay: q̈ = ω² (s(t − delay) − q) − 2 ζ ω q̇.
struct ServoBelief {
  double omega_radps = 25.1327;
  double zeta = 0.7;
  double delay_s = 0.0024;
};

}  // namespace motionlab::controller
