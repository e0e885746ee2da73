/// @file  How the second ship moves, from its motion reference unit alone.
#pragma once

#include <optional>

#include "drivers/core/time.hpp"
#include "gateway/estimator/belief.hpp"
#include "gateway/estimator/ship_model.hpp"
#include "gateway/estimator/ship_states.hpp"
#include "gateway/math/moving_base.hpp"
#include "gateway/math/sparse_kalman.hpp"
#include "idl/mru.hpp"

namespace motionlab::estimator {

/// An extended Kalman filter of 33 states (see ShipStates) that is fed by one unit.
///
/// No camera sees this ship. Roll and pitch are known to the unit's accuracy, and so is velocity at wave
/// frequencies. Place is not observable from accelerations: the filter's own idea of it is worth nothing, so
/// surge, sway and heave are its velocity less the slow part of it (20 s), integrated with a leak (8 s).
/// Waves of 7 s come out 11° early and a few percent small. Heading is the unit's own, which drifts.
///
/// Not `valid` before the unit has been heard for `kSettling`, nor after it was silent for half a second;
/// when it is heard again everything begins anew.
class SecondShip {
 public:
  static constexpr Nanoseconds kSettling = 20s;

  SecondShip(const MruMount& mount, const ShipBelief& ship, const MruBelief& mru, double gravity_mps2);

  /// Takes in the newest sample; one that was seen before, is unstable, not finite, older than the last or
  /// from the future does no harm. Never allocates.
  void step(LabTime t, const std::optional<topic::Mru>& mru);

  [[nodiscard]] bool valid() const { return valid_; }
  /// The motion at the time of the last `step`, carried forward from the last measurement.
  [[nodiscard]] math::BodyMotion motion() const;
  /// Standard deviation of the origin's place, world axes [m]: the filter's, which is on the safe side.
  [[nodiscard]] Eigen::Vector3d p_sd_m() const;

 private:
  using Filter = math::KalmanState<ShipStates::kSize>;

  void begin(LabTime t);
  void predict(double dt_s);
  void integrate(double dt_s);

  MruMount mount_;
  MruBelief belief_;
  double gravity_;
  ShipModel model_;
  math::Matrix3d R_WD_;
  Filter filter_;
  Eigen::Vector3d slow_v_ = Eigen::Vector3d::Zero();  ///< what of the velocity is no wave, W [m/s]
  Eigen::Vector3d place_ = Eigen::Vector3d::Zero();   ///< offset from neutral at t_, W [m]
  std::optional<LabTime> heard_since_;
  LabTime t_{};    ///< time of the filter's state
  LabTime now_{};  ///< time of the last step
  std::uint64_t seen_ = 0;
  bool valid_ = false;
};

}  // namespace motionlab::estimator
