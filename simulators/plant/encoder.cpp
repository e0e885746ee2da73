#include "simulators/plant/encoder.hpp"

#include <cmath>

namespace motionlab::plant {

JointEncoders::Reading JointEncoders::read(const Joints& q_rad, const Joints& qd_radps) {
  Reading reading{};
  const double quantum = config_.joint_quantum_rad;
  for (std::size_t j = 0; j < q_rad.size(); ++j) {
    const double q = q_rad[j] + config_.joint_noise_rms_rad * random_.normal();
    reading.q_rad[j] = quantum > 0 ? quantum * std::round(q / quantum) : q;
    reading.qd_radps[j] = qd_radps[j] + config_.joint_speed_noise_rms_radps * random_.normal();
  }
  return reading;
}

}  // namespace motionlab::plant
