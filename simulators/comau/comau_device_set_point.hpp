/// @file  How the robot program turns a wanted joint velocity into a position target, once per control cycle.
#pragma once

#include "drivers/comau/comau_wire.hpp"

namespace motionlab::comau {

/// Integrates velocity to position inside a box, with room left to brake before its edge.
///
/// Each joint's velocity is clipped to [lower, upper] with upper = min(v_max, sqrt(2 a d), d / T), d the
/// distance to the upper edge, likewise below (Flacco, De Luca, Khatib 2012); then q += v T; then q is
/// clipped to the box. The clip is made of the minimum and maximum that pass over NaN, as in the real
/// program: a wanted NaN becomes the lower bound, i.e. full speed towards the lower edge.
class SetPoint {
 public:
  struct Config {
    Joints q_min_rad{};
    Joints q_max_rad{};
    Joints qd_max_radps{};
    double deceleration_radps2 = 1.0;
    double cycle_s = kCycleSeconds;
  };

  explicit SetPoint(const Config& config) noexcept : config_(config) {}

  /// Takes the target from where the arm is, at rest, box or no box.
  void synchronise(const Joints& q_measured_rad) noexcept;
  /// One cycle.
  void integrate(const Joints& qd_wanted_radps) noexcept;
  /// The applied velocity, each joint nearer to the wanted one by at most acceleration x cycle. @pre finite
  [[nodiscard]] Joints approached(const Joints& qd_wanted_radps,
                                  const Joints& acceleration_radps2) const noexcept;

  [[nodiscard]] const Joints& q_rad() const noexcept { return q_rad_; }
  /// The velocity of the last cycle, after the clip.
  [[nodiscard]] const Joints& qd_radps() const noexcept { return qd_radps_; }
  [[nodiscard]] bool at_rest() const noexcept { return qd_radps_ == Joints{}; }

 private:
  Config config_;
  Joints q_rad_{};
  Joints qd_radps_{};
};

}  // namespace motionlab::comau
