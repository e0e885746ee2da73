/// @file  Whether the arm does what it is told: not at all, or at a share of the speed.
#pragma once

#include <array>

#include "drivers/comau/comau_wire.hpp"

namespace motionlab::comau {

/// Compares what was sent with where the joints went. The answer says neither drive state nor modality nor
/// override, so this is all that can be known of them.
///
/// Ignored: for `ignored_after_s` at least one joint was told to go a way worth watching and none has gone a
/// tenth of it in that direction. Judged by positions, so that an answer whose values stand still counts too.
///
/// Share: least squares of the joints' measured steps over the steps of a first-order lag of what was sent,
/// forgetting with `memory_s`. Below one, something between us and the joints slows the arm down: the
/// pendant's override, or a speed limit below ours.
class ResponseWatch {
 public:
  struct Config {
    double ignored_after_s = 0.2;
    double reaction_s = 0.06;  ///< lag from a sent velocity to the measured one
    double memory_s = 1.0;
  };

  explicit ResponseWatch(const Config& config) noexcept : config_(config) {}

  /// One answer. @param qd_sent_radps  what was told since the last one, `dt_s` ago
  void step(const std::array<float, kJointCount>& qd_sent_radps, const Joints& q_measured_rad,
            double dt_s) noexcept;
  /// Nothing is asked of the arm: what was learnt says nothing any more.
  void reset() noexcept { *this = ResponseWatch{config_}; }

  [[nodiscard]] bool ignored() const noexcept { return ignored_; }
  /// Measured over wanted motion; 1 until `memory_s` was watched and while too little is wanted to tell.
  [[nodiscard]] double share() const noexcept;

 private:
  void watch_whether(const std::array<float, kJointCount>& qd_sent_radps, const Joints& q_rad,
                     double dt_s) noexcept;
  void watch_how_much(const std::array<float, kJointCount>& qd_sent_radps, const Joints& q_rad,
                      double dt_s) noexcept;

  Config config_;
  bool begun_ = false;
  Joints q_before_rad_{};

  // Whether it moves.
  Joints q_watched_rad_{};  ///< where the joints were when the watch began …
  Joints told_rad_{};       ///< … and how far each was told to go since
  double watched_s_ = 0.0;
  bool ignored_ = false;

  // How much of what was wanted.
  double learnt_s_ = 0.0;
  Joints lagged_radps_{};
  double wanted_measured_ = 0.0;
  double wanted_squared_ = 0.0;
};

}  // namespace motionlab::comau
