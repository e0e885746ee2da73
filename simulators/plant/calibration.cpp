#include "simulators/plant/calibration.hpp"

#include <Eigen/Geometry>

#include "simulators/plant/noise.hpp"

namespace motionlab::plant {

Calibration disturbed(const Calibration& published, double offset_m, double angle_rad, std::uint64_t seed) {
  Random random(seed, "calibration");
  const auto disturb = [&](math::RigidTransform& X) {
    X.p += offset_m * direction(random);
    X.R = X.R * Eigen::AngleAxisd(angle_rad, direction(random)).toRotationMatrix();
  };
  Calibration truth = published;
  disturb(truth.em8000_to_comau);
  disturb(truth.em8000_to_mru1);
  disturb(truth.world_to_qtm);
  disturb(truth.em1500_to_mru2);
  return truth;
}

}  // namespace motionlab::plant
