/// @file  How the rates and accelerations of Euler angles and those of the body belong together, for both
/// sequences and in both directions (thesis Eq 3.62–3.75, corrected). The rate of the body is expressed in
/// the body throughout.
#pragma once

#include <optional>

#include "gateway/math/rotation.hpp"

namespace motionlab::math {

/// E(rpy) with omega_body = E d(rpy)/dt. Never singular in itself; not invertible at a pitch of ±90°. 3x3.
[[nodiscard]] Matrix3d euler_rates_to_body(const Vector3d& rpy_rad, EulerOrder order);

/// dE/dt along the given Euler rates. 3x3.
[[nodiscard]] Matrix3d euler_rates_to_body_dot(const Vector3d& rpy_rad, const Vector3d& rpy_dot_radps,
                                               EulerOrder order);

/// The smallest |cos pitch| at which angles still have rates: 0.0057° from the singular pitch.
inline constexpr double kSmallestCosPitch = 1e-4;

/// T = E⁻¹, d(rpy)/dt = T omega_body: thesis Eq 3.68 for `zyx`. Nothing within `smallest_cos_pitch` of the
/// singular pitch. 3x3.
[[nodiscard]] std::optional<Matrix3d> body_to_euler_rates(const Vector3d& rpy_rad, EulerOrder order,
                                                          double smallest_cos_pitch = kSmallestCosPitch);

/// dT/dt along the given Euler rates. Nothing near the singular pitch. 3x3. (Thesis Eq 3.74 as printed is not
/// this derivative.)
[[nodiscard]] std::optional<Matrix3d> body_to_euler_rates_dot(const Vector3d& rpy_rad,
                                                              const Vector3d& rpy_dot_radps, EulerOrder order,
                                                              double smallest_cos_pitch = kSmallestCosPitch);

/// Euler angles that move.
struct EulerMotion {
  Vector3d rpy_rad = Vector3d::Zero();
  Vector3d rate_radps = Vector3d::Zero();
  Vector3d acceleration_radps2 = Vector3d::Zero();
};

/// A body that turns; both expressed in the body.
struct BodyTurn {
  Vector3d omega_radps = Vector3d::Zero();
  Vector3d alpha_radps2 = Vector3d::Zero();
};

/// omega = E rpy', alpha = E rpy'' + E' rpy'. The same as the corrected thesis Eq 3.75,
/// v' = J⁻¹ (eta'' − J' v); as printed, with J' eta', it is wrong.
[[nodiscard]] BodyTurn body_turn(const EulerMotion& motion, EulerOrder order);

/// The inverse of `body_turn` at the given angles. Nothing near the singular pitch.
[[nodiscard]] std::optional<EulerMotion> euler_motion(const Vector3d& rpy_rad, const BodyTurn& turn,
                                                      EulerOrder order,
                                                      double smallest_cos_pitch = kSmallestCosPitch);

}  // namespace motionlab::math
