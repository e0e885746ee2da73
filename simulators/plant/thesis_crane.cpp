#include "simulators/plant/thesis_crane.hpp"

#include <cmath>
#include <numbers>

#include "gateway/math/pendulum.hpp"
#include "simulators/plant/platform.hpp"

namespace motionlab::plant {

using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

math::RigidTransform printed_mount() {
  math::RigidTransform X_BR;
  X_BR.R << -0.4972, 0.8676, -0.0050, 0.8676, 0.4972, 0.0012, 0.0036, -0.0037, -1.0000;
  X_BR.p << -1.0820, 1.5360, -1.0245;
  return X_BR;
}

Scenario wave_at_once(bool wave) {
  Scenario scenario;
  scenario.sea = wave ? Sea::thesis_wave : Sea::calm;
  scenario.fade_in_s = 0;
  return scenario;
}

}  // namespace

double ThesisWire::length_m(double t) const {
  return mean_m + amplitude_m * std::sin(2 * std::numbers::pi * frequency_hz * t);
}

double ThesisWire::speed_mps(double t) const {
  const double w = 2 * std::numbers::pi * frequency_hz;
  return amplitude_m * w * std::cos(w * t);
}

ThesisMount ThesisMount::on_ship() {
  ThesisMount mount;
  mount.X_WN.R = Vector3d(1, -1, -1).asDiagonal();
  mount.X_BR = printed_mount();
  mount.X_BR.R = math::nearest_rotation(mount.X_BR.R);
  return mount;
}

ThesisMount ThesisMount::on_ship_as_printed() {
  ThesisMount mount;
  mount.X_WN.R = Vector3d(1, 1, -1).asDiagonal();
  mount.X_BR = printed_mount();
  mount.heave_upside_down = true;
  return mount;
}

ThesisCrane::ThesisCrane(const ThesisMount& mount, bool wave, const ThesisWire& wire, double gravity)
    : mount_(mount), wave_(wave), wire_(wire), gravity_(gravity), motion_(wave_at_once(wave), 0) {}

ShipCoordinates ThesisCrane::ship(double t) const {
  return wave_ ? motion_.at(t) : ShipCoordinates{};
}

math::PointMotion ThesisCrane::tool(double t, const State& s, const Vector3d& a_RT) const {
  const PlatformState platform = platform_state(mount_.X_WN, ship(t));
  const PointMotion point = point_of(platform, mount_.X_BR * Vector3d(s.head<3>()),
                                     mount_.X_BR.R * s.segment<3>(3), mount_.X_BR.R * a_RT);
  return {point.p_W, point.v_W, point.a_W};
}

ThesisCrane::State ThesisCrane::rate(double t, const State& s, const Vector3d& a_RT) const {
  const Vector2d angles = s.segment<2>(6), rates = s.segment<2>(8);
  Vector3d a_WT = tool(t, s, a_RT).a;
  if (mount_.heave_upside_down) a_WT.z() = -a_WT.z();
  State rate;
  rate << s.segment<3>(3), a_RT, rates,
      math::swing_acceleration<double>(angles, rates, a_WT, wire_.length_m(t), wire_.speed_mps(t), gravity_);
  return rate;
}

Vector3d ThesisCrane::p_WL(double t, const State& s) const {
  return tool(t, s, Vector3d::Zero()).p +
         wire_.length_m(t) * math::wire_direction<double>(Vector2d(s.segment<2>(6)));
}

Vector3d ThesisCrane::at_neutral(const Vector3d& p_R) const {
  return mount_.X_WN * (mount_.X_BR * p_R);
}

}  // namespace motionlab::plant
