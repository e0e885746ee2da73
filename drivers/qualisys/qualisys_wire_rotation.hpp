/// @file  Orientation as Qualisys writes it: a matrix column by column, or three angles.
#pragma once

#include <array>

namespace motionlab::qualisys {

/// Greatest deviation of any element of RᵀR from the identity that still counts as a rotation: single
/// precision gives 1e-6, a wrong layout or units give 1.
inline constexpr double kRotationTolerance = 1e-3;

/// Row-major, as mathematics writes it; the wire is column-major.
using Matrix = std::array<std::array<double, 3>, 3>;

[[nodiscard]] bool is_rotation(const Matrix& r) noexcept;

/// Unit quaternion w, x, y, z with w >= 0. @pre is_rotation(r)
[[nodiscard]] std::array<double, 4> to_quaternion(const Matrix& r) noexcept;
[[nodiscard]] Matrix to_matrix(const std::array<double, 4>& q) noexcept;

/// Roll, pitch, yaw [rad] of the definition "Qualisys standard", R = Rx(roll) Ry(pitch) Rz(yaw): about the
/// body's own axes in this order, right-handed. Pitch within ±π/2, where it is singular; the others within
/// ±π. A project may define other angles, and the stream does not say so: control uses the matrix.
[[nodiscard]] std::array<double, 3> to_angles(const Matrix& r) noexcept;
[[nodiscard]] Matrix from_angles(const std::array<double, 3>& roll_pitch_yaw_rad) noexcept;

}  // namespace motionlab::qualisys
