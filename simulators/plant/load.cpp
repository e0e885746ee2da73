#include "simulators/plant/load.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace motionlab::plant {

using Eigen::Vector3d;

namespace {

struct Wire {
  double tension_n;
  Vector3d swing_damping_n;  ///< on the load's centre
  Vector3d to_tool;          ///< unit vector along the wire
};

Wire wire_force(const LoadConfig& c, const LoadState& load, const Suspension& at) {
  const double below = c.below_hook_m();
  const double free_wire = at.free_length_m - below;
  const Vector3d p_WT = at.p_WT + load.tip_m, v_WT = at.v_WT + load.tip_mps;
  const Vector3d d = p_WT - (load.p_WL + below * load.up);
  const double length = d.norm();
  if (length <= free_wire) return {0, Vector3d::Zero(), Vector3d::Zero()};
  const Vector3d u = d / length;
  const double rate = u.dot(v_WT - (load.v_WL + below * load.omega_radps.cross(load.up)));
  const double k = c.wire_ea_n / free_wire;
  const double damper = 2 * c.wire_damping_ratio * std::sqrt(k * c.mass_kg);
  const double tension = k * (length - free_wire) + damper * (rate - at.length_rate_mps);
  if (tension <= 0) return {0, Vector3d::Zero(), Vector3d::Zero()};
  const double swing = 2 * c.swing_damping_ratio * std::sqrt(c.gravity_mps2 / at.free_length_m) * c.mass_kg;
  const Vector3d v = v_WT - load.v_WL;
  return {tension, swing * (v - u.dot(v) * u), u};
}

/// Middle of the cubic through values and slopes at both ends.
Suspension middle(const Suspension& b, const Suspension& e, double h) {
  return {0.5 * (b.p_WT + e.p_WT) + h / 8 * (b.v_WT - e.v_WT),
          1.5 / h * (e.p_WT - b.p_WT) - 0.25 * (b.v_WT + e.v_WT),
          0.5 * (b.free_length_m + e.free_length_m) + h / 8 * (b.length_rate_mps - e.length_rate_mps),
          1.5 / h * (e.free_length_m - b.free_length_m) - 0.25 * (b.length_rate_mps + e.length_rate_mps)};
}

LoadState moved(const LoadState& s, double h, const LoadRates& r) {
  return {s.p_WL + h * r.v_WL,         s.v_WL + h * r.a_WL, s.up + h * r.up,
          s.omega_radps + h * r.omega, s.tip_m + h * r.tip, s.tip_mps + h * r.tip_mps};
}

LoadRates mean(const LoadRates& a, const LoadRates& b, const LoadRates& c, const LoadRates& d) {
  const auto of = [&](Vector3d LoadRates::*x) {
    return Vector3d((a.*x + 2 * (b.*x) + 2 * (c.*x) + d.*x) / 6);
  };
  return {of(&LoadRates::v_WL),  of(&LoadRates::a_WL), of(&LoadRates::up),
          of(&LoadRates::omega), of(&LoadRates::tip),  of(&LoadRates::tip_mps)};
}

}  // namespace

LoadState Load::at_rest(const Vector3d& p_WT, double free_length_m) const {
  const double weight = config_.mass_kg * config_.gravity_mps2;
  const double wire = free_length_m - config_.below_hook_m();
  LoadState s{p_WT, Vector3d::Zero()};
  if (arm_.flexible) s.tip_m.z() = -weight / (arm_.mass_kg * arm_.omega_radps() * arm_.omega_radps());
  s.p_WL += s.tip_m - (free_length_m + wire * weight / config_.wire_ea_n) * Vector3d::UnitZ();
  return s;
}

double Load::tension_n(const LoadState& load, const Suspension& at) const {
  return wire_force(config_, load, at).tension_n;
}

Vector3d Load::acceleration_mps2(const LoadState& load, const Suspension& at) const {
  return rates(load, at, Vector3d::Zero(), Vector3d::Zero()).a_WL;
}

LoadRates Load::rates(const LoadState& load, const Suspension& at, const Vector3d& a_WT,
                      const Vector3d& push_n) const {
  const LoadConfig& c = config_;
  const Wire wire = wire_force(c, load, at);
  const Vector3d pull = wire.tension_n * wire.to_tool;
  const double area = std::numbers::pi * c.radius_m * c.radius_m;
  const double drag = 0.5 * c.air_density_kgpm3 * c.drag_coefficient * area * load.v_WL.norm();

  LoadRates r;
  r.v_WL = load.v_WL;
  r.a_WL = (pull + wire.swing_damping_n - drag * load.v_WL + push_n) / c.mass_kg;
  r.a_WL.z() -= c.gravity_mps2;
  r.up = r.omega = r.tip = r.tip_mps = Vector3d::Zero();
  if (c.rigid_body) {
    const double inertia = c.mass_kg * c.gyration_radius_m * c.gyration_radius_m;
    const double stiffness = c.mass_kg * c.gravity_mps2 * c.hook_to_centre_m;
    const double damping = 2 * c.tilt_damping_ratio * std::sqrt(stiffness * inertia);
    r.up = load.omega_radps.cross(load.up);
    r.omega = (c.hook_to_centre_m * load.up.cross(pull) - damping * load.omega_radps) / inertia;
  }
  if (arm_.flexible) {
    const double w = arm_.omega_radps();
    r.tip = load.tip_mps;
    r.tip_mps = -w * w * load.tip_m - 2 * arm_.damping_ratio * w * load.tip_mps - a_WT -
                (pull + wire.swing_damping_n) / arm_.mass_kg;
  }
  return r;
}

LoadState Load::step(const LoadState& s, const Suspension& begin, const Suspension& end, double h,
                     const Vector3d& push_n) const {
  const Suspension mid = middle(begin, end, h);
  const Vector3d a_WT = (end.v_WT - begin.v_WT) / h;
  const LoadRates k1 = rates(s, begin, a_WT, push_n);
  const LoadRates k2 = rates(moved(s, h / 2, k1), mid, a_WT, push_n);
  const LoadRates k3 = rates(moved(s, h / 2, k2), mid, a_WT, push_n);
  const LoadRates k4 = rates(moved(s, h, k3), end, a_WT, push_n);
  LoadState next = moved(s, h, mean(k1, k2, k3, k4));
  next.up.normalize();
  return next;
}

Eigen::Vector2d swing_angles_rad(const Vector3d& p_WT, const Vector3d& p_WL) {
  const Vector3d d = p_WL - p_WT;
  const double length = d.norm();
  if (length == 0) return Eigen::Vector2d::Zero();
  return {std::asin(std::clamp(-d.x() / length, -1.0, 1.0)), std::atan2(d.y(), -d.z())};
}

Eigen::Vector2d tilt_angles_rad(const LoadState& load) {
  return swing_angles_rad(load.up, Vector3d::Zero());
}

}  // namespace motionlab::plant
