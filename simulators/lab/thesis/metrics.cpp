#include "simulators/lab/thesis/metrics.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace motionlab::thesis {
namespace {

using Eigen::Vector3d;

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kWithin = 1.0 * kDegree;

/// Tab 3.1, with the forearm of the code (1.4922 m); wrist and tool in line with it.
constexpr math::CraneArmGeometry kArm{0.35, 1.16, 0.25, 0.83, 1.4922 + 0.210 + 0.567};

std::array<double, 3> array(const Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}

}  // namespace

MetricsCollector::MetricsCollector(const Run& run, double from_s)
    : from_ms_(std::llround(from_s * 1e3)),
      arm_(run.scenario->system != System::pendulum),
      kinematics_(kArm),
      events_ms_(Reference(run.scenario->reference).events_ms(run.scenario->offset)) {
  sums_.joint_min_deg.fill(std::numeric_limits<double>::infinity());
  sums_.joint_max_deg.fill(-std::numeric_limits<double>::infinity());
}

void MetricsCollector::take(const Sample& s) {
  if (s.t_ms < from_ms_) return;
  ++sums_.samples;
  last_ms_ = s.t_ms;
  if (!s.state.allFinite()) sums_.finite = false;
  const Eigen::Vector2d swing = s.state.segment<2>(6);
  for (std::size_t i = 0; i < 2; ++i) {
    const double angle = swing[static_cast<Eigen::Index>(i)];
    sums_.swing_axis_rms_deg[i] += angle * angle;
    sums_.swing_axis_max_deg[i] = std::max(sums_.swing_axis_max_deg[i], std::abs(angle) / kDegree);
  }
  const Vector3d tool = s.state.head<3>() - s.p_RT_reference, load = s.p_WL - s.p_WL_set;
  sums_.tool_rms_m += tool.squaredNorm();
  sums_.tool_rms_xy_m += tool.head<2>().squaredNorm();
  sums_.tool_world_rms_m += (s.p_WT - s.p_WT_set).squaredNorm();
  sums_.load_rms_m += load.squaredNorm();
  sums_.load_rms_xy_m += load.head<2>().squaredNorm();
  sums_.load_rms_z_m += load.z() * load.z();
  sums_.command_max_mps2 = std::max(sums_.command_max_mps2, s.command.cwiseAbs().maxCoeff());
  sums_.command_rms_mps2 += s.command.squaredNorm();
  sums_.angle_estimate_rms_deg += (s.sight.estimate.segment<2>(6) - swing).squaredNorm();

  const auto close = [this] {
    if (outside_ms_ < 0) return;
    settle_s_ = std::max(settle_s_, 1e-3 * static_cast<double>(outside_ms_ - events_ms_[event_]));
  };
  while (event_ + 1 < events_ms_.size() && s.t_ms >= events_ms_[event_ + 1]) {
    close();
    censored_ = censored_ || (outside_ms_ >= 0 && outside_ms_ == s.t_ms - 1);
    outside_ms_ = -1;
    ++event_;
  }
  if (s.t_ms >= events_ms_[event_] && swing.cwiseAbs().maxCoeff() > kWithin) outside_ms_ = s.t_ms;
  if (arm_) take_arm(s);
}

void MetricsCollector::take_arm(const Sample& s) {
  const Vector3d p = s.state.head<3>();
  const double reach = std::hypot(std::hypot(p.x(), p.y()) - kArm.a1_m, p.z() - kArm.d1_m);
  sums_.reach_max_m = std::max(sums_.reach_max_m, reach);
  const auto q = kinematics_.inverse(p);
  if (!q) {
    sums_.reach_ok = false;
    return;
  }
  const Vector3d qd = kinematics_.jacobian(*q).partialPivLu().solve(s.state.segment<3>(3));
  for (std::size_t i = 0; i < 3; ++i) {
    const auto axis = static_cast<Eigen::Index>(i);
    sums_.joint_speed_max_degps[i] = std::max(sums_.joint_speed_max_degps[i], std::abs(qd[axis]) / kDegree);
    sums_.joint_min_deg[i] = std::min(sums_.joint_min_deg[i], (*q)[axis] / kDegree);
    sums_.joint_max_deg[i] = std::max(sums_.joint_max_deg[i], (*q)[axis] / kDegree);
  }
}

Metrics MetricsCollector::metrics() const {
  Metrics m = sums_;
  const auto n = static_cast<double>(std::max<std::uint64_t>(m.samples, 1));
  const auto rms = [n](double& squares) { squares = std::sqrt(squares / n); };
  for (double& angle : m.swing_axis_rms_deg) angle = std::sqrt(angle / n) / kDegree;
  for (double* squares : {&m.tool_rms_m, &m.tool_rms_xy_m, &m.tool_world_rms_m, &m.load_rms_m,
                          &m.load_rms_xy_m, &m.load_rms_z_m, &m.angle_estimate_rms_deg}) {
    rms(*squares);
  }
  m.angle_estimate_rms_deg /= kDegree;
  m.command_rms_mps2 = std::sqrt(m.command_rms_mps2 / n);
  m.settle_1deg_s = settle_s_;
  m.settle_censored = censored_;
  if (outside_ms_ >= 0) {
    m.settle_1deg_s = std::max(settle_s_, 1e-3 * static_cast<double>(outside_ms_ - events_ms_[event_]));
    m.settle_censored = censored_ || outside_ms_ == last_ms_;
  }
  return m;
}

Metrics measure(const Run& run, double from_s) {
  MetricsCollector collector(run, from_s);
  simulate(run, [&collector](const Sample& sample) { collector.take(sample); });
  return collector.metrics();
}

namespace {

monitor::MotionSample scored(const Sample& s) {
  return {{s.state[6], s.state[7]}, array(s.p_WL - s.p_WL_set), array(s.p_WT - s.p_WT_set)};
}

/// Statistics in the words of the report.
struct Scored {
  monitor::MotionStatistics motion;
  monitor::Settling settling;

  void take(const Sample& s) {
    const monitor::MotionSample sample = scored(s);
    motion.add(sample);
    settling.add(LabTime{} + Nanoseconds{s.t_ms * 1'000'000}, monitor::swing_deg(sample));
  }
};

}  // namespace

monitor::Report report(const Run& run) {
  Scored own, twin;
  MetricsCollector collector(run);
  double wire_speed = 0;
  simulate(run, [&](const Sample& s) {
    own.take(s);
    collector.take(s);
    wire_speed = std::max(wire_speed, std::abs(s.wire_speed_mps));
  });
  const bool arm = run.scenario->system != System::pendulum;
  if (arm) {  // a pendulum that nobody moves stands still: nothing to compare with
    Run alone = run;
    alone.controller = Controller::none;
    alone.estimator = Estimator::ideal;
    alone.noise = false;
    simulate(alone, [&twin](const Sample& s) { twin.take(s); });
  }

  monitor::Report report;
  report.labels.scenario = run.scenario->name;
  report.labels.controller = to_string(run.controller);
  report.labels.estimator = to_string(run.estimator);
  report.labels.sensors = run.noise ? "real" : "ideal";
  report.labels.seed = run.seed;
  report.labels.world = "thesis";
  report.labels.frame = to_string(run.frame);
  report.labels.gains = run.has_gains() ? to_string(run.weights) : "";
  report.duration_s = run.duration_s;
  report.motion = own.motion.score();
  report.settling_time_s = own.settling.time_s(LabTime{});
  report.baseline = twin.motion.score();
  report.baseline_settling_time_s = twin.settling.time_s(LabTime{});
  if (arm) {
    report.winch_speed_max_mps = wire_speed;
    const auto speed = collector.metrics().joint_speed_max_degps;
    report.joint_speed_max_degps = {speed[0], speed[1], speed[2], 0, 0, 0};
  }
  return report;
}

}  // namespace motionlab::thesis
