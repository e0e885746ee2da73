/// @file  Every number of the simulated world. Defaults: the laboratory's published values and, where there
/// are none, assumptions (deploy/config/world.toml says which is which).
#pragma once

#include "gateway/math/crane_arm.hpp"
#include "simulators/plant/arm_mode.hpp"
#include "simulators/plant/arm_servo.hpp"
#include "simulators/plant/calibration.hpp"
#include "simulators/plant/camera_sensor.hpp"
#include "simulators/plant/encoder.hpp"
#include "simulators/plant/load.hpp"
#include "simulators/plant/mru_sensor.hpp"
#include "simulators/plant/sea.hpp"
#include "simulators/plant/winch_servo.hpp"

namespace motionlab::plant {

/// In what the world differs from what the gateway is told. A small number proves nothing in a world that is
/// its own model.
struct Differences {
  double joint_bandwidth_factor = 0.9;    ///< on omega of all joints: 10 % slower
  double sensor_extra_latency_s = 0.003;  ///< MRUs and cameras are older than published
  double calibration_offset_m = 0.0005;   ///< robot base, MRU mounts, camera system; direction from the seed
  double calibration_angle_rad = 0.000872664626;  ///< 0.05°
  double wire_extra_m = 0.002;                    ///< wire is longer than the winch says
  double mru_noise_factor = 1.0;                  ///< on every random error of the MRUs

  static Differences none() { return {1.0, 0.0, 0.0, 0.0, 0.0, 1.0}; }
};

struct WorldConfig {
  Calibration calibration;  ///< as published
  math::CraneArmGeometry arm_geometry{0.350, 1.160, 0.250, 0.830, 1.4922 + 0.210 + 0.567};
  Joints home_rad{0, 0, -1.5707963267948966, 0, 0, 0};
  double start_wire_length_m = 2.0;  ///< by the winch's encoder; the twin keeps it
  ArmServoConfig arm;
  ArmMode arm_mode;
  WinchServoConfig winch;
  LoadConfig load;
  MruConfig mru1;
  MruConfig mru2 = MruConfig::second_ship();
  CameraConfig camera;
  EncoderConfig encoder;
  Differences differences;
  Scenario second_ship;  ///< how EM1500 moves; calm: it stands still

  /// Belief is truth: no differences, a nearly rigid wire, a rigid arm, a point mass, white noise only.
  [[nodiscard]] WorldConfig as_believed() const;
  /// Sensors without noise, bias or drift; rates, latencies and the high-pass of the MRUs stay.
  [[nodiscard]] WorldConfig with_perfect_sensors() const;
  static WorldConfig ideal() { return WorldConfig{}.as_believed(); }
};

}  // namespace motionlab::plant
