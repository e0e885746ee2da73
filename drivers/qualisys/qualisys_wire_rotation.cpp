#include "drivers/qualisys/qualisys_wire_rotation.hpp"

#include <algorithm>
#include <cmath>

namespace motionlab::qualisys {

bool is_rotation(const Matrix& r) noexcept {
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      const double dot = r[0][i] * r[0][j] + r[1][i] * r[1][j] + r[2][i] * r[2][j];
      if (!(std::abs(dot - (i == j ? 1.0 : 0.0)) <= kRotationTolerance)) return false;
    }
  }
  const double determinant = r[0][0] * (r[1][1] * r[2][2] - r[1][2] * r[2][1]) -
                             r[0][1] * (r[1][0] * r[2][2] - r[1][2] * r[2][0]) +
                             r[0][2] * (r[1][0] * r[2][1] - r[1][1] * r[2][0]);
  return determinant > 0.0;
}

/// Starts from the largest component, so that it never divides by a small one.
std::array<double, 4> to_quaternion(const Matrix& r) noexcept {
  const double trace = r[0][0] + r[1][1] + r[2][2];
  std::array<double, 4> q{};
  if (trace > 0.0) {
    q = {1.0 + trace, r[2][1] - r[1][2], r[0][2] - r[2][0], r[1][0] - r[0][1]};
  } else {
    std::size_t i = 0;
    if (r[1][1] > r[0][0]) i = 1;
    if (r[2][2] > r[i][i]) i = 2;
    const std::size_t j = (i + 1) % 3;
    const std::size_t k = (i + 2) % 3;
    q[0] = r[k][j] - r[j][k];
    q[1 + i] = 1.0 + r[i][i] - r[j][j] - r[k][k];
    q[1 + j] = r[j][i] + r[i][j];
    q[1 + k] = r[k][i] + r[i][k];
  }
  const double norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  const double scale = q[0] < 0.0 ? -1.0 / norm : 1.0 / norm;
  for (double& element : q) element *= scale;
  return q;
}

Matrix to_matrix(const std::array<double, 4>& q) noexcept {
  const auto [w, x, y, z] = q;
  return {{{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
           {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
           {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}}};
}

std::array<double, 3> to_angles(const Matrix& r) noexcept {
  return {std::atan2(-r[1][2], r[2][2]), std::asin(std::clamp(r[0][2], -1.0, 1.0)),
          std::atan2(-r[0][1], r[0][0])};
}

Matrix from_angles(const std::array<double, 3>& roll_pitch_yaw_rad) noexcept {
  const auto [roll, pitch, yaw] = roll_pitch_yaw_rad;
  const double sr = std::sin(roll), cr = std::cos(roll);
  const double sp = std::sin(pitch), cp = std::cos(pitch);
  const double sy = std::sin(yaw), cy = std::cos(yaw);
  return {{{cp * cy, -cp * sy, sp},
           {cr * sy + sr * sp * cy, cr * cy - sr * sp * sy, -sr * cp},
           {sr * sy - cr * sp * cy, sr * cy + cr * sp * sy, cr * cp}}};
}

}  // namespace motionlab::qualisys
