/// @file  A small laboratory for the estimator's tests: a ship on sinusoids, an arm, a pendulum in Cartesian
/// coordinates, and sensors with noise and latency. It shares no equation with the estimator: every rate and
/// acceleration is a numerical derivative of a pose.
#pragma once

#include <Eigen/Dense>
#include <cmath>
#include <deque>
#include <optional>
#include <utility>

#include "drivers/core/random.hpp"
#include "gateway/estimator/lab_estimator.hpp"

namespace motionlab::test {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::Vector4d;

inline constexpr double kPi = 3.14159265358979323846;
inline constexpr double kDegree = kPi / 180;

/// The calibration that the laboratory publishes, with a misaligned motion reference unit.
inline estimator::Calibration published_calibration() {
  using math::RigidTransform;
  estimator::Calibration c;
  c.X_WN = RigidTransform::from_quaternion(
      {6.0198987883e-05, 0.705931944115, 0.708279565403954, 0.000379322138596},
      {-2.969661622702265, 1.976311036084776, 2.662845015592614});
  c.X_BR = RigidTransform::from_quaternion(
      {0.002461288106714, -0.501408337431486, -0.865206982556575, 0.000706081011787},
      {-1.082024099747949, 1.536041691521612, -1.024461448780775});
  c.X_BM = {math::from_euler(Vector3d(0.13, 0.38, 1.5) * kDegree, math::EulerOrder::zyx),
            {-1.289, 0.576, -0.966}};
  c.p_MO = c.X_BM.inverse().p;
  c.X_WQ = RigidTransform::from_quaternion({0.0, 0.7077, 0.7065, 0.0004}, {0.6925, -0.7793, 1.4229});
  c.X_BP = {math::rot_z(0.3), {0.4, -0.2, -0.1}};
  c.arm = {0.350, 1.160, 0.250, 0.830, 1.4922 + 0.210 + 0.567};
  return c;
}

struct Pose {
  Matrix3d R;
  Vector3d p;
};

/// What the arm does.
enum class Arm {
  holds_tool,  ///< keeps the tool where it is in the world, as when the controller works
  rests,       ///< stays in its posture: the tool goes with the ship
  wanders,     ///< holds the tool to a point that itself moves through the world
};

struct LaboratoryOptions {
  bool platform_body = true;
  Arm arm = Arm::holds_tool;
  bool wire_moves = false;
  double noise = 1.0;                ///< 1: about what the real sensors have; 0: none
  double swing_rad = 0.5 * kDegree;  ///< to begin with
  double mru_latency_s = 0.005;
  double camera_latency_s = 0.007;
  double arm_latency_s = 0.001;
  std::uint64_t seed = 1;
};

/// One sample under way.
template <class Sample>
class Line {
 public:
  void put(double arrival_s, const Sample& sample) { queue_.push_back({arrival_s, sample}); }
  /// The newest sample that has arrived.
  const std::optional<Sample>& newest(double t) {
    while (!queue_.empty() && queue_.front().first <= t + 1e-9) {
      newest_ = queue_.front().second;
      queue_.pop_front();
    }
    return newest_;
  }

 private:
  std::deque<std::pair<double, Sample>> queue_;
  std::optional<Sample> newest_;
};

class Laboratory {
 public:
  explicit Laboratory(const LaboratoryOptions& options = {})
      : options_(options), calibration_(published_calibration()), random_(options.seed) {
    // The level frame: z down, x where the platform's own x points.
    Vector3d x = calibration_.X_WN.R * Vector3d::UnitX();
    x.z() = 0;
    x.normalize();
    R_WD_.col(0) = x;
    R_WD_.col(1) = Vector3d(0, 0, -1).cross(x);
    R_WD_.col(2) = Vector3d(0, 0, -1);
    p_WL_ = tool(0) + wire(0) * Vector3d(std::sin(options.swing_rad), 0, -std::cos(options.swing_rad));
    v_WL_ = tool_velocity();
  }

  [[nodiscard]] double t() const { return t_; }
  [[nodiscard]] const estimator::Calibration& calibration() const { return calibration_; }

  [[nodiscard]] Pose ship(double t) const {
    const double fade = t < 5 ? std::pow(std::sin(0.1 * kPi * std::max(t, 0.0)), 4) : 1.0;
    const auto wave = [&](double amplitude, double frequency, double phase_deg) {
      return fade * amplitude * std::sin(2 * kPi * frequency * t + phase_deg * kDegree);
    };
    const double roll = wave(5 * kDegree, 0.15, 90), pitch = wave(5 * kDegree, 0.10, 0),
                 yaw = wave(5 * kDegree, 0.20, 120);
    const Matrix3d R =
        (Eigen::AngleAxisd(yaw, Vector3d::UnitZ()) * Eigen::AngleAxisd(pitch, Vector3d::UnitY()) *
         Eigen::AngleAxisd(roll, Vector3d::UnitX()))
            .toRotationMatrix();
    return {R_WD_ * R,
            calibration_.X_WN.p + Vector3d(wave(0.1, 0.10, 0), wave(0.2, 0.10, 45), wave(0.2, 0.10, 90))};
  }

  [[nodiscard]] Vector3d joints(double t) const {
    if (options_.arm == Arm::rests) return {0, 0, -kPi / 2};
    Vector3d p_WT(0.847625, -0.407825, 5.919269);
    if (options_.arm == Arm::wanders) {
      p_WT += Vector3d(0.10 * std::sin(0.6 * t), 0.08 * std::sin(0.7 * t + 1), 0.06 * std::sin(0.8 * t + 2));
    }
    const Pose X = ship(t);
    const Vector3d p_RT = calibration_.X_BR.inverse() * (X.R.transpose() * (p_WT - X.p));
    return math::CraneArm(calibration_.arm).inverse(p_RT).value();
  }

  [[nodiscard]] double wire(double t) const {
    return options_.wire_moves ? 2.0 + 0.15 * std::sin(0.5 * t) : 2.0;
  }

  [[nodiscard]] Vector3d tool(double t) const {
    const Pose X = ship(t);
    return X.R * (calibration_.X_BR * math::CraneArm(calibration_.arm).position(joints(t))) + X.p;
  }

  [[nodiscard]] const Vector3d& load() const { return p_WL_; }
  [[nodiscard]] const Vector3d& load_velocity() const { return v_WL_; }
  [[nodiscard]] Vector3d tool_velocity() const {
    return rate([this](double t) { return tool(t); }, t_);
  }

  /// A hand that pushes the load, until it is set to zero again.
  void push(const Vector3d& acceleration) { push_ = acceleration; }

  /// One millisecond further: the load moves, sensors measure, samples travel.
  void step() {
    constexpr double dt = 0.001;
    step_load(dt);
    ++milliseconds_;
    t_ = 1e-3 * static_cast<double>(milliseconds_);
    if (milliseconds_ % 5 == 0) measure_mru();
    if (milliseconds_ % 5 == 2) measure_cameras();
    if (milliseconds_ % 2 == 0) measure_arm();
    if (milliseconds_ % 5 == 1) measure_winch();
  }

  /// What has arrived by now.
  [[nodiscard]] estimator::Inputs inputs() {
    estimator::Inputs in;
    in.t = time(t_);
    in.mru = mru_.newest(t_);
    in.load = load_.newest(t_);
    if (options_.platform_body) in.platform = platform_.newest(t_);
    in.arm = arm_.newest(t_);
    in.winch = winch_.newest(t_);
    return in;
  }

  static LabTime time(double t) { return LabTime{from_seconds(t)}; }

  /// Hides bodies from the cameras: samples go on, untracked and with a zero pose.
  bool load_hidden = false;
  bool platform_hidden = false;

 private:
  template <class F>
  static Vector3d rate(const F& f, double t) {
    constexpr double h = 1e-3;
    return (f(t + h) - f(t - h)) / (2 * h);
  }
  template <class F>
  static Vector3d second_rate(const F& f, double t) {
    constexpr double h = 1e-3;
    return (f(t + h) - 2 * f(t) + f(t - h)) / (h * h);
  }
  /// Rate of turn in the body's axes, from the rotation between two times.
  [[nodiscard]] Vector3d omega_B(double t) const {
    constexpr double h = 1e-4;
    const Eigen::AngleAxisd turn(Matrix3d(ship(t - h).R.transpose() * ship(t + h).R));
    return turn.angle() * turn.axis() / (2 * h);
  }
  [[nodiscard]] Vector3d noise(double sd) {
    return options_.noise * sd * Vector3d(random_.normal(), random_.normal(), random_.normal());
  }
  static std::array<double, 3> array(const Vector3d& v) { return {v.x(), v.y(), v.z()}; }

  /// A point mass on a wire of given length: the pull is what keeps |p_WL − p_WT| at the wire's length.
  [[nodiscard]] Vector3d load_acceleration(double t, const Vector3d& p, const Vector3d& v) const {
    const Vector3d r = p - tool(t);
    const Vector3d r_dot = v - rate([this](double s) { return tool(s); }, t);
    const Vector3d a_WT = second_rate([this](double s) { return tool(s); }, t);
    constexpr double h = 1e-3;
    const double L = wire(t), L_dot = (wire(t + h) - wire(t - h)) / (2 * h);
    const double L_ddot = (wire(t + h) - 2 * L + wire(t - h)) / (h * h);
    const Vector3d free = Vector3d(0, 0, -9.81) + push_;
    const double pull =
        (r.dot(free - a_WT) + r_dot.squaredNorm() - L_dot * L_dot - L * L_ddot) / r.squaredNorm();
    return free - pull * r;
  }

  void step_load(double dt) {
    const Vector3d p = p_WL_, v = v_WL_;
    const Vector3d a1 = load_acceleration(t_, p, v);
    const Vector3d v2 = v + 0.5 * dt * a1;
    const Vector3d a2 = load_acceleration(t_ + 0.5 * dt, p + 0.5 * dt * v, v2);
    const Vector3d v3 = v + 0.5 * dt * a2;
    const Vector3d a3 = load_acceleration(t_ + 0.5 * dt, p + 0.5 * dt * v2, v3);
    const Vector3d v4 = v + dt * a3;
    const Vector3d a4 = load_acceleration(t_ + dt, p + dt * v3, v4);
    p_WL_ = p + dt / 6 * (v + 2 * v2 + 2 * v3 + v4);
    v_WL_ = v + dt / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
    // What the integration adds to the wire is taken off again.
    const double after = t_ + dt;
    const Vector3d along = (p_WL_ - tool(after)).normalized();
    const Vector3d v_WT = rate([this](double s) { return tool(s); }, after);
    const double wire_speed = (wire(after + 1e-3) - wire(after - 1e-3)) / 2e-3;
    p_WL_ = tool(after) + along * wire(after);
    v_WL_ += along * (wire_speed - along.dot(v_WL_ - v_WT));
  }

  void measure_mru() {
    const Matrix3d R_DM = R_WD_.transpose() * ship(t_).R * calibration_.X_BM.R;
    const Vector3d rpy(std::atan2(R_DM(2, 1), R_DM(2, 2)), std::asin(-R_DM(2, 0)),
                       std::atan2(R_DM(1, 0), R_DM(0, 0)));
    // A constant error of the vertical, which also leaks gravity, and a heading that is off.
    const Vector3d tilt = options_.noise * Vector3d(3e-4, -2e-4, 0.01);
    const Vector3d a_D = R_WD_.transpose() * second_rate([this](double s) { return ship(s).p; }, t_);
    Vector3d a_H = Eigen::AngleAxisd(-rpy.z(), Vector3d::UnitZ()) * a_D;
    a_H += 9.81 * Vector3d(-tilt.y(), tilt.x(), 0);
    topic::Mru s;
    s.sequence_number = ++mru_count_;
    s.t_measured_ns = to_ns(time(t_));
    s.stable = true;
    s.euler_heading_mru_rad = array(rpy + tilt + noise(1e-4));
    s.omega_mru_radps = array(calibration_.X_BM.R.transpose() * omega_B(t_) + noise(3e-4));
    s.a_heading_origin_mps2 = array(a_H + options_.noise * Vector3d(0.02, -0.01, -0.038) + noise(0.01));
    mru_.put(t_ + options_.mru_latency_s, s);
  }

  void measure_cameras() {
    const math::RigidTransform X_QW = calibration_.X_WQ.inverse();
    topic::Bodies s;
    s.sequence_number = ++frame_;
    s.t_measured_ns = to_ns(time(t_));
    s.tracked = !load_hidden;
    if (s.tracked) {
      s.p_camera_body_m = array(X_QW * p_WL_ + noise(1e-3));
      s.q_camera_body = {1, 0, 0, 0};
    }
    load_.put(t_ + options_.camera_latency_s, s);
    const Pose X = ship(t_);
    const math::RigidTransform X_QP = X_QW * math::RigidTransform{X.R, X.p} * calibration_.X_BP;
    const Vector3d turn = noise(0.05 * kDegree);
    const Matrix3d wobble(Eigen::AngleAxisd(
        turn.norm(), turn.norm() > 0 ? Vector3d(turn.normalized()) : Vector3d(Vector3d::UnitX())));
    topic::Bodies body;
    body.sequence_number = frame_;
    body.t_measured_ns = s.t_measured_ns;
    body.tracked = !platform_hidden;
    if (body.tracked) {
      const Eigen::Quaterniond q(Matrix3d(X_QP.R * wobble));
      body.p_camera_body_m = array(X_QP.p + noise(1e-3));
      body.q_camera_body = {q.w(), q.x(), q.y(), q.z()};
    }
    platform_.put(t_ + options_.camera_latency_s, body);
  }

  void measure_arm() {
    topic::ArmState s;
    s.sequence_number = ++arm_count_;
    s.t_measured_ns = to_ns(time(t_));
    const Vector3d q = joints(t_), qd = rate([this](double t) { return joints(t); }, t_);
    for (std::size_t i = 0; i < 3; ++i) {
      s.q_rad[i] = q[static_cast<int>(i)];
      s.qd_radps[i] = qd[static_cast<int>(i)];
    }
    arm_.put(t_ + options_.arm_latency_s, s);
  }

  void measure_winch() {
    topic::WinchState s;
    s.sequence_number = ++winch_count_;
    s.t_measured_ns = to_ns(time(t_));
    s.wire_length_m = wire(t_);
    s.wire_speed_mps = (wire(t_ + 1e-3) - wire(t_ - 1e-3)) / 2e-3;
    winch_.put(t_ + 0.002, s);
  }

  LaboratoryOptions options_;
  estimator::Calibration calibration_;
  Random random_;
  Matrix3d R_WD_;
  Vector3d p_WL_, v_WL_, push_ = Vector3d::Zero();
  std::int64_t milliseconds_ = 0;
  double t_ = 0;
  std::uint64_t mru_count_ = 0, frame_ = 0, arm_count_ = 0, winch_count_ = 0;
  Line<topic::Mru> mru_;
  Line<topic::Bodies> load_, platform_;
  Line<topic::ArmState> arm_;
  Line<topic::WinchState> winch_;
};

inline estimator::Belief belief_of(const Laboratory& laboratory) {
  estimator::Belief belief;
  belief.calibration = laboratory.calibration();
  return belief;
}

inline Vector3d vector(const std::array<double, 3>& a) {
  return {a[0], a[1], a[2]};
}

}  // namespace motionlab::test
