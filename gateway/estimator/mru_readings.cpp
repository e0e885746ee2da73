#include "gateway/estimator/mru_readings.hpp"

namespace motionlab::estimator {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr auto axis = ShipStates::axis;

Vector3d vector(const std::array<double, 3>& a) {
  return Eigen::Map<const Vector3d>(a.data());
}

}  // namespace

MruReadings compare(const topic::Mru& mru, const ShipView& ship, const MruMount& mount,
                    const MruBelief& belief, double gravity) {
  MruReadings readings;
  const auto& X_BM = mount.X_BM;
  const Vector3d rpy = ship.triple(0, 3), rpy_dot = ship.triple(1, 3);
  const Matrix3d T = math::euler_zyx_rates_to_body(rpy);
  const Matrix3d R_MB = X_BM.R.transpose();
  // The unit's attitude in D is that of B times the mounting.
  const Matrix3d R_DM = math::from_euler(rpy, math::EulerOrder::zyx) * X_BM.R;
  const Vector3d rpy_zyx = math::to_euler(R_DM, math::EulerOrder::zyx);

  // Angles. Small changes follow the zyx angles of the unit in either order, near enough for a gain.
  const Vector3d rpy_M = math::to_euler(R_DM, mount.order);
  const Matrix3d on_euler = math::euler_zyx_rates_to_body(rpy_zyx).inverse() * R_MB * T;
  for (int i = 0; i < 3; ++i) {
    MruReading& reading = readings[static_cast<std::size_t>(i)];
    const int error = i < 2 ? ShipStates::kTiltError + i : ShipStates::kYawError;
    for (int j = 0; j < 3; ++j) reading.row.add(axis(3 + j, 0), on_euler(i, j));
    reading.row.add(error, 1.0);
    reading.innovation = wrapped(vector(mru.euler_heading_mru_rad)[i] - rpy_M[i] - ship[error]);
    reading.kind = Reading::mru_angle;
    reading.sd = belief.angle_noise_rad;
  }

  // Rates, in the unit's body frame.
  const Matrix3d on_rate = R_MB * T;
  Matrix3d on_angle;
  for (int j = 0; j < 3; ++j) {
    on_angle.col(j) = R_MB * math::euler_zyx_rates_to_body_dot(rpy, Vector3d::Unit(j)) * rpy_dot;
  }
  for (int i = 0; i < 3; ++i) {
    MruReading& reading = readings[static_cast<std::size_t>(3 + i)];
    const int bias = ShipStates::kRateBias + i;
    for (int j = 0; j < 3; ++j) {
      reading.row.add(axis(3 + j, 1), on_rate(i, j));
      reading.row.add(axis(3 + j, 0), on_angle(i, j));
    }
    reading.row.add(bias, 1.0);
    reading.innovation = vector(mru.omega_mru_radps)[i] - on_rate.row(i).dot(rpy_dot) - ship[bias];
    reading.kind = Reading::mru_rate;
    reading.sd = belief.rate_noise_radps;
  }

  // Accelerations in the unit's heading frame, of the point O that the unit takes for B's origin: its lever
  // arm knows nothing of the misalignment. A tilt error turns gravity into acceleration.
  const Vector3d p_BO = X_BM * mount.p_MO;
  const math::BodyMotion now = ship.motion();
  const Matrix3d R_HW = math::rot_z(-rpy_zyx.z()) * ship.R_WD().transpose();
  const Matrix3d on_turn = -R_HW * now.X_WB.R * math::hat(p_BO) * T;
  const Vector3d a_H = R_HW * math::carried(now, {p_BO, Vector3d::Zero(), Vector3d::Zero()}).a;
  for (int i = 0; i < 3; ++i) {
    MruReading& reading = readings[static_cast<std::size_t>(6 + i)];
    const int bias = ShipStates::kAccelerationBias + i;
    double expected = a_H[i] + ship[bias];
    for (int j = 0; j < 3; ++j) {
      reading.row.add(axis(j, 2), R_HW(i, j));
      reading.row.add(axis(3 + j, 2), on_turn(i, j));
    }
    reading.row.add(bias, 1.0);
    if (i < 2) {
      const int tilt = ShipStates::kTiltError + 1 - i;
      const double leaked = i == 0 ? -gravity : gravity;
      reading.row.add(tilt, leaked);
      expected += leaked * ship[tilt];
    }
    reading.innovation = vector(mru.a_heading_origin_mps2)[i] - expected;
    reading.kind = Reading::mru_acceleration;
    reading.sd = belief.acceleration_noise_mps2;
  }
  return readings;
}

}  // namespace motionlab::estimator
