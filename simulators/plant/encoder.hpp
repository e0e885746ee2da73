/// @file  What an encoder makes of a true position.
#pragma once

#include <cstdint>

#include "simulators/plant/arm_servo.hpp"
#include "simulators/plant/noise.hpp"

namespace motionlab::plant {

struct EncoderConfig {
  double joint_noise_rms_rad = 5e-6;
  double joint_quantum_rad = 1e-5;
  double joint_speed_noise_rms_radps = 1e-4;

  static EncoderConfig perfect() { return {0, 0, 0}; }
};

/// The joint encoders: white noise, then quantised. Joint 3 against the vertical like every joint value here.
class JointEncoders {
 public:
  JointEncoders(const EncoderConfig& config, std::uint64_t seed)
      : config_(config), random_(seed, "encoders") {}

  struct Reading {
    Joints q_rad;
    Joints qd_radps;
  };
  [[nodiscard]] Reading read(const Joints& q_rad, const Joints& qd_radps);

 private:
  EncoderConfig config_;
  Random random_;
};

}  // namespace motionlab::plant
