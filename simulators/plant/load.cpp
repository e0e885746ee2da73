#include "simulators/plant/load.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace motionlab::plant {

using Eigen::Vector3d;

namespace {

struct Wire {
  double tension_n;
  Vector3d swing_damping_n;
  Vector3d to_tool;  ///< unit vector
};

Wire wire_force(const LoadConfig& c, const LoadState& load, const Suspension& at) {
  const Vector3d d = at.p_WT - load.p_WL;
  const double length = d.norm();
  if (length <= at.free_length_m) return {0, Vector3d::Zero(), Vector3d::Zero()};
  const Vector3d u = d / length;
  const Vector3d v = at.v_WT - load.v_WL;
  const double rate = u.dot(v);
  const double k = c.wire_ea_n / at.free_length_m;
  const double damper = 2 * c.wire_damping_ratio * std::sqrt(k * c.mass_kg);
  const double tension = k * (length - at.free_length_m) + damper * (rate - at.length_rate_mps);
  if (tension <= 0) return {0, Vector3d::Zero(), Vector3d::Zero()};
  const double swing = 2 * c.swing_damping_ratio * std::sqrt(c.gravity_mps2 / at.free_length_m) * c.mass_kg;
  return {tension, swing * (v - rate * u), u};
}

/// Middle of the cubic through values and slopes at both ends.
Suspension middle(const Suspension& b, const Suspension& e, double h) {
  return {0.5 * (b.p_WT + e.p_WT) + h / 8 * (b.v_WT - e.v_WT),
          1.5 / h * (e.p_WT - b.p_WT) - 0.25 * (b.v_WT + e.v_WT),
          0.5 * (b.free_length_m + e.free_length_m) + h / 8 * (b.length_rate_mps - e.length_rate_mps),
          1.5 / h * (e.free_length_m - b.free_length_m) - 0.25 * (b.length_rate_mps + e.length_rate_mps)};
}

}  // namespace

LoadState Load::at_rest(const Vector3d& p_WT, double free_length_m) const {
  const double length = free_length_m * (1 + config_.mass_kg * config_.gravity_mps2 / config_.wire_ea_n);
  return {p_WT - length * Vector3d::UnitZ(), Vector3d::Zero()};
}

double Load::tension_n(const LoadState& load, const Suspension& at) const {
  return wire_force(config_, load, at).tension_n;
}

Vector3d Load::acceleration_mps2(const LoadState& load, const Suspension& at) const {
  const Wire wire = wire_force(config_, load, at);
  const double area = std::numbers::pi * config_.radius_m * config_.radius_m;
  const double drag = 0.5 * config_.air_density_kgpm3 * config_.drag_coefficient * area * load.v_WL.norm();
  Vector3d a = (wire.tension_n * wire.to_tool + wire.swing_damping_n - drag * load.v_WL) / config_.mass_kg;
  a.z() -= config_.gravity_mps2;
  return a;
}

LoadState Load::step(const LoadState& s, const Suspension& begin, const Suspension& end, double h) const {
  const Suspension mid = middle(begin, end, h);
  const Vector3d k1 = acceleration_mps2(s, begin);
  const LoadState s2{s.p_WL + h / 2 * s.v_WL, s.v_WL + h / 2 * k1};
  const Vector3d k2 = acceleration_mps2(s2, mid);
  const LoadState s3{s.p_WL + h / 2 * s2.v_WL, s.v_WL + h / 2 * k2};
  const Vector3d k3 = acceleration_mps2(s3, mid);
  const LoadState s4{s.p_WL + h * s3.v_WL, s.v_WL + h * k3};
  const Vector3d k4 = acceleration_mps2(s4, end);
  return {s.p_WL + h / 6 * (s.v_WL + 2 * s2.v_WL + 2 * s3.v_WL + s4.v_WL),
          s.v_WL + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)};
}

Eigen::Vector2d swing_angles_rad(const Vector3d& p_WT, const Vector3d& p_WL) {
  const Vector3d d = p_WL - p_WT;
  const double length = d.norm();
  if (length == 0) return Eigen::Vector2d::Zero();
  return {std::asin(std::clamp(-d.x() / length, -1.0, 1.0)), std::atan2(d.y(), -d.z())};
}

}  // namespace motionlab::plant
