/// @file  What a motion reference unit reads, against what the states of its ship say that it should.
#pragma once

#include <array>
#include <cmath>

#include "gateway/estimator/belief.hpp"
#include "gateway/estimator/innovations.hpp"
#include "gateway/estimator/ship_states.hpp"
#include "gateway/math/sparse_kalman.hpp"
#include "idl/mru.hpp"

namespace motionlab::estimator {

/// The smallest angle that is equal to a up to whole turns.
[[nodiscard]] inline double wrapped(double a) {
  return std::remainder(a, 2 * std::acos(-1.0));
}

/// One number of a sample.
struct MruReading {
  Reading kind{};
  math::SparseRow row;    ///< its derivative with respect to the ship's states
  double innovation = 0;  ///< read − expected
  double sd = 0;          ///< of its noise
};

inline constexpr int kMruReadings = 9;
using MruReadings = std::array<MruReading, kMruReadings>;

/// The nine readings of a sample that are used - angles, rates, unfiltered accelerations - linearised at the
/// states of `ship`. The high-passed positions and velocities are not used: they hold nothing that the
/// accelerations do not.
[[nodiscard]] MruReadings compare(const topic::Mru& mru, const ShipView& ship, const MruMount& mount,
                                  const MruBelief& belief, double gravity_mps2);

}  // namespace motionlab::estimator
