/// @file  From wanted velocities to the command on the wire: clamped, ramped, never a step into mode 0.
#pragma once

#include "drivers/comau/comau_wire.hpp"

namespace motionlab::comau {

/// Makes one command per command period. Knows no time and no reasons; starts at rest in mode 0.
class VelocityShaper {
 public:
  struct Config {
    double period_s = 0.005;
    double rest_before_hold_s = 0.1;
    Joints stop_deceleration_radps2{};
    Joints qd_max_radps{};
  };

  explicit VelocityShaper(const Config& config) noexcept : config_(config) {}

  /// Towards rest: speeds fall by at most deceleration x period, then rest in mode 1, then mode 0.
  /// @param sudden  nobody wanted this: when `follow` is called again, speeds rise again with the same limit
  Command brake(bool sudden) noexcept;

  /// The wanted velocities, clamped. @pre finite
  Command follow(const Joints& qd_wanted_radps) noexcept;

  /// Nothing moves and mode 0 is what is said.
  [[nodiscard]] bool holding() const noexcept {
    return current_.mode == static_cast<std::int32_t>(Mode::hold);
  }

 private:
  Config config_;
  Command current_{};
  int periods_at_rest_ = 0;
  bool rejoining_ = false;
};

}  // namespace motionlab::comau
