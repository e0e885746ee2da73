#include "simulators/plant/thesis_pendulum.hpp"

#include "gateway/math/pendulum.hpp"

namespace motionlab::plant {

ThesisPendulum::State ThesisPendulum::rate(const State& s, double u) const {
  return {s[1], u, s[3], math::planar_swing_acceleration(s[2], s[3], u, 0.0, length_m_, 0.0, gravity_)};
}

}  // namespace motionlab::plant
