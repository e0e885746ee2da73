/// @file  What the camera system makes of the true poses of load and platform.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

#include "gateway/math/rotation.hpp"
#include "simulators/plant/noise.hpp"

namespace motionlab::plant {

struct CameraConfig {
  double period_s = 0.005;
  double latency_s = 0.007;  ///< exposure to client; applied by whoever sends
  double marker_noise_rms_m = 0.0005;
  int load_markers = 4;
  int platform_markers = 6;
  double correlated_rms_m = 0.001;  ///< slow error of each body and axis
  double correlation_s = 1.0;
  double angle_noise_rms_rad = 0.05 * 0.017453292519943295;
  double dropouts_per_minute = 0.0;  ///< of each body
  double dropout_s = 0.5;
  bool platform_tracked = true;  ///< is there a marker body on the platform?

  /// No noise and no dropouts; rate and latency stay.
  [[nodiscard]] CameraConfig without_errors() const;
};

/// One body in one frame, in camera axes.
struct BodyReading {
  bool tracked = false;       ///< false: the rest is zero and means nothing
  math::RigidTransform X_QB;  ///< pose of the body in the camera frame
  double residual_m = 0;
};

/// Where the load's own axes point: its z along the wire towards the tool point, x in the plane of world x
/// and the wire (yaw 0). With swing (alpha, beta): R_WL = Rx(beta) Ry(alpha).
[[nodiscard]] Eigen::Matrix3d load_orientation(const Eigen::Vector2d& swing_rad);

/// The camera system at its frame rate: white noise, smaller with more markers; a slow error; random
/// dropouts. Body "platform" is the platform's frame B itself.
class CameraSensor {
 public:
  /// @param X_WQ  where the camera system's frame truly is
  CameraSensor(const CameraConfig& config, const math::RigidTransform& X_WQ, std::uint64_t seed);

  struct Frame {
    BodyReading load;
    BodyReading platform;
  };
  /// Sees both bodies; to be called once a period.
  [[nodiscard]] Frame sample(const math::RigidTransform& X_WL, const math::RigidTransform& X_WB);

  [[nodiscard]] const CameraConfig& config() const { return config_; }

 private:
  struct Body {
    double white_rms_m;
    std::array<GaussMarkov, 3> slow;
    int hidden_frames;
  };
  [[nodiscard]] Body body(int markers);
  [[nodiscard]] BodyReading see(Body& body, const math::RigidTransform& X_WB);

  CameraConfig config_;
  math::RigidTransform X_QW_;
  Random random_;
  Body load_, platform_;
};

}  // namespace motionlab::plant
