#include "simulators/lab/thesis/simulation.hpp"

#include <cmath>
#include <memory>
#include <numbers>

#include "drivers/core/random.hpp"
#include "gateway/controller/load_law.hpp"
#include "gateway/controller/smooth_point.hpp"
#include "gateway/controller/thesis_laws.hpp"
#include "gateway/estimator/thesis_ekf10.hpp"
#include "gateway/estimator/thesis_ekf35.hpp"
#include "gateway/estimator/thesis_filter4.hpp"
#include "gateway/math/integrate.hpp"
#include "gateway/math/rotation.hpp"
#include "simulators/plant/thesis_crane.hpp"
#include "simulators/plant/thesis_pendulum.hpp"

namespace motionlab::thesis {
namespace {

using Eigen::Vector3d;
using Eigen::Vector4d;
using plant::ThesisCrane;
using State = ThesisCrane::State;

constexpr double kStep = 1e-3;
constexpr double kDegree = std::numbers::pi / 180;

/// Measurement noise as a filter believes it, or none.
class Noise {
 public:
  explicit Noise(const Run& run) : on_(run.noise), random_(run.seed, "thesis") {}

  template <class Vector>
  Vector on(const Vector& exact, const Vector& variances) {
    if (!on_) return exact;
    Vector noisy = exact;
    for (Eigen::Index i = 0; i < noisy.size(); ++i) noisy[i] += std::sqrt(variances[i]) * random_.normal();
    return noisy;
  }

 private:
  bool on_;
  Random random_;
};

std::int64_t steps_of(const Run& run) {
  return std::llround(run.duration_s / kStep);
}

// ---- load and motion ----

/// The 10-state filter between a crane on the ground and a law.
class GroundEye {
 public:
  explicit GroundEye(const Run& run) : noise_(run), filter_({}, home_m()) {
    const estimator::ThesisEkf10Config believed;
    variances_.head<3>().setConstant(std::pow(believed.measurement_deviation_position_m, 2));
    variances_.tail<2>().setConstant(std::pow(believed.measurement_deviation_angle_rad, 2));
  }

  Sight see(const ThesisCrane&, double, const State& x) {
    estimator::ThesisEkf10::Measurement exact;
    exact << x.head<3>(), x.segment<2>(6);
    const estimator::ThesisEkf10::Measurement measured = noise_.on(exact, variances_);
    filter_.update(measured);
    return {filter_.state().x, measured.tail<2>()};
  }
  void go_on(const ThesisCrane&, double, const Vector3d& u) { filter_.predict(u); }

 private:
  Noise noise_;
  estimator::ThesisEkf10::Measurement variances_;
  estimator::ThesisEkf10 filter_;
};

/// The 35-state filter between a crane on a ship and a law.
class ShipEye {
  using Filter = estimator::ThesisEkf35;

 public:
  ShipEye(const Run& run, const ThesisCrane& crane)
      : noise_(run), filter_(belief(run.frame), home_m(), crane.wire().length_m(0)) {}

  Sight see(const ThesisCrane& crane, double t, const State& x) {
    const plant::ShipCoordinates ship = crane.ship(t);
    const math::Matrix3d T = math::euler_zyx_rates_to_body(ship.eta.tail<3>());
    Filter::Measurement exact;
    exact << ship.eta, ship.eta_dot.head<3>(), T * ship.eta_dot.tail<3>(), x.head<6>(),
        crane.wire().length_m(t), x.tail<4>();
    const Filter::Measurement measured = noise_.on(exact, filter_.measurement_variances());
    filter_.update(measured);
    const Filter::State& all = filter_.state().x;
    State seen;
    seen << all.segment<6>(Filter::kP), all.segment<4>(Filter::kPhi);
    constexpr Eigen::Index kSwingRow = 19;  // of kRows, where phi is
    return {seen, measured.segment<2>(kSwingRow), measured.head<6>(), all.segment<6>(Filter::kEta)};
  }
  void go_on(const ThesisCrane& crane, double t, const Vector3d& u) {
    filter_.predict(Vector4d(u.x(), u.y(), u.z(), crane.wire().length_m(t)));
  }

 private:
  static estimator::ThesisEkf35Config belief(Frame frame) {
    estimator::ThesisEkf35Config config;
    if (frame == Frame::thesis) {
      config.R_WN.setIdentity();
      config.R_BR = estimator::thesis_R_BR_as_printed();
    }
    return config;
  }

  Noise noise_;
  Filter filter_;
};

std::unique_ptr<controller::ThesisLoadLaw> load_law(const Run& run) {
  using namespace controller;
  switch (run.controller) {
    case Controller::none:
      return std::make_unique<ThesisLoadRest>();
    case Controller::prefilter:
      return std::make_unique<ThesisLoadPrefilter>(thesis_load_prefilter(run.weights));
    case Controller::damper:
      return std::make_unique<ThesisLoadDamper>();
    case Controller::integral:
    case Controller::ours:  // has no law of this kind, see CraneRun::ours
      break;
  }
  if (run.scenario->system == System::load) {
    return std::make_unique<ThesisLoadIntegral>(thesis_load_integral(run.weights));
  }
  const estimator::ThesisEkf35Config believed;
  const math::Matrix3d R_WR = run.frame == Frame::world ? math::Matrix3d(believed.R_WN * believed.R_BR)
                                                        : estimator::thesis_R_BR_as_printed();
  return std::make_unique<ThesisLoadIntegral>(thesis_motion_integral(run.weights, R_WR));
}

/// One run of a crane.
class CraneRun {
 public:
  using Memory = controller::ThesisLoadLaw::Memory;

  CraneRun(const Run& run, const Observer& observer)
      : run_(run),
        observer_(observer),
        reference_(run.scenario->reference),
        crane_(mount(run), run.scenario->wave,
               {run.scenario->wire_m, run.scenario->wire_sinus ? 0.75 : 0.0, 0.05}),
        law_(load_law(run)) {
    x_.setZero();
    x_.head<3>() = home_m();
    if (run.scenario->offset) x_.segment<2>(6) << 15 * kDegree, 20 * kDegree;
  }

  void go() {
    if (run_.controller == Controller::ours) return ours();
    switch (run_.estimator) {
      case Estimator::ekf10:
        return sampled(GroundEye(run_));
      case Estimator::ekf35:
        return sampled(ShipEye(run_, crane_));
      default:
        return ideal();
    }
  }

 private:
  static plant::ThesisMount mount(const Run& run) {
    if (run.scenario->system == System::load) return {};
    return run.frame == Frame::world ? plant::ThesisMount::on_ship()
                                     : plant::ThesisMount::on_ship_as_printed();
  }

  static State about_home(State x) {
    x.head<3>() -= home_m();
    return x;
  }

  void ideal() {
    using Both = Eigen::Matrix<double, 14, 1>;
    for (std::int64_t k = 0; k < steps_of(run_); ++k) {
      const double t0 = static_cast<double>(k) * kStep;
      const Eigen::Matrix<double, 6, 1> eta = crane_.ship(t0).eta;
      show(k, {x_, x_.segment<2>(6), eta, eta}, law_->command(about_home(x_), memory_, reference_.at(k, t0)));
      const auto rate = [&](double t, const Both& both) {
        const State x = both.head<10>(), seen = about_home(x);
        const Memory memory = both.tail<4>();
        const Vector3d r = reference_.at(k, t);
        Both d;
        d << crane_.rate(t, x, law_->command(seen, memory, r)), law_->memory_rate(seen, memory, r);
        return d;
      };
      Both both;
      both << x_, memory_;
      both = math::rk4_step(rate, t0, both, kStep);
      x_ = both.head<10>();
      memory_ = both.tail<4>();
    }
  }

  template <class Eye>
  void sampled(Eye eye) {
    for (std::int64_t k = 0; k < steps_of(run_); ++k) {
      const double t0 = static_cast<double>(k) * kStep;
      const Sight sight = eye.see(crane_, t0, x_);
      const State seen = about_home(sight.estimate);
      const Vector3d r = reference_.at(k, t0);
      const Vector3d u = law_->command(seen, memory_, r);
      show(k, sight, u);
      memory_ += kStep * law_->memory_rate(seen, memory_, r);
      x_ = math::rk4_step([&](double t, const State& x) { return crane_.rate(t, x, u); }, t0, x_, kStep);
      eye.go_on(crane_, t0, u);
    }
  }

  /// How fast the load hangs away from the tool point: d/dt of L lambda (Eq 3.49).
  [[nodiscard]] Vector3d offset_rate(double t, const State& x) const {
    const double sa = std::sin(x[6]), ca = std::cos(x[6]), sb = std::sin(x[7]), cb = std::cos(x[7]);
    const Vector3d lambda(-sa, ca * sb, -ca * cb);
    const Vector3d rate(-ca * x[8], ca * cb * x[9] - sa * sb * x[8], sa * cb * x[8] + ca * sb * x[9]);
    return crane_.wire().speed_mps(t) * lambda + crane_.wire().length_m(t) * rate;
  }

  /// Our law moves a tool point in software, smoothly to where the thesis asks at once; the crane, which can
  /// accelerate at will, follows it on the moving ship. The wire is the thesis', so height is the tool's
  /// task.
  void ours() {
    constexpr double kFollow = 20.0;  // rad/s
    controller::LoadLaw law({});
    controller::SmoothPoint place({});
    for (std::int64_t k = 0; k < steps_of(run_); ++k) {
      const double t0 = static_cast<double>(k) * kStep;
      const math::PointMotion tool = crane_.tool(t0, x_, Vector3d::Zero());
      const Vector3d set = crane_.at_neutral(home_m() + reference_.at(k, t0));
      if (k == 0) {
        law.start(tool.p, tool.v, set.z());
        place.reset(set);
      }
      place.step(kStep, set);
      law.set_tool_height(place.p().z());
      const double wire = crane_.wire().length_m(t0);
      law.step(kStep, {.reference = {place.p() - wire * Vector3d::UnitZ(), place.v(), place.a()},
                       .p_WL = crane_.p_WL(t0, x_),
                       .v_WL = tool.v + offset_rate(t0, x_),
                       .wire_length_m = wire});
      const Vector3d a_WT =
          law.a_WT() + 2 * kFollow * (law.v_WT() - tool.v) + kFollow * kFollow * (law.p_WT() - tool.p);
      math::Matrix3d by_u;  // R_WR, for the acceleration in W is affine in the command
      for (int i = 0; i < 3; ++i) by_u.col(i) = crane_.tool(t0, x_, Vector3d::Unit(i)).a - tool.a;
      const Vector3d u = by_u.transpose() * (a_WT - tool.a);
      const Eigen::Matrix<double, 6, 1> eta = crane_.ship(t0).eta;
      show(k, {x_, x_.segment<2>(6), eta, eta}, u);
      x_ = math::rk4_step([&](double t, const State& x) { return crane_.rate(t, x, u); }, t0, x_, kStep);
    }
  }

  void show(std::int64_t k, const Sight& sight, const Vector3d& u) const {
    const double t = static_cast<double>(k) * kStep;
    const Vector3d p_RT_set = home_m() + reference_.at(k, t);
    const Vector3d p_WT_set = crane_.at_neutral(p_RT_set);
    const double wire = crane_.wire().length_m(t);
    observer_({k, x_, sight, p_RT_set, u, crane_.tool(t, x_, u).p, crane_.p_WL(t, x_), p_WT_set,
               p_WT_set - wire * Vector3d::UnitZ(), wire, crane_.wire().speed_mps(t), crane_.ship(t).eta});
  }

  const Run& run_;
  const Observer& observer_;
  Reference reference_;
  ThesisCrane crane_;
  std::unique_ptr<controller::ThesisLoadLaw> law_;
  State x_;
  Memory memory_ = Memory::Zero();
};

// ---- pendulum ----

std::unique_ptr<controller::ThesisPendulumLaw> pendulum_law(const Run& run) {
  using namespace controller;
  switch (run.controller) {
    case Controller::prefilter:
      return std::make_unique<ThesisPendulumPrefilter>(thesis_pendulum_prefilter(run.weights));
    case Controller::integral:
      return std::make_unique<ThesisPendulumIntegral>(thesis_pendulum_integral(run.weights));
    case Controller::damper:
      return std::make_unique<ThesisPendulumDamper>();
    case Controller::none:
    case Controller::ours:
      break;
  }
  return nullptr;
}

/// One run of the pendulum. Without a law the cart is pushed as in Fig 4.20, from 20 deg, for the filters.
class PendulumRun {
 public:
  PendulumRun(const Run& run, const Observer& observer)
      : run_(run),
        observer_(observer),
        reference_(run.controller == Controller::none ? ReferenceKind::home : run.scenario->reference),
        pendulum_(run.scenario->wire_m),
        law_(pendulum_law(run)) {
    if (!law_) x_[2] = 20 * kDegree;
  }

  void go() {
    switch (run_.estimator) {
      case Estimator::kf4:
        return sampled(estimator::ThesisKf4());
      case Estimator::ekf4:
        return sampled(estimator::ThesisEkf4());
      default:
        return ideal();
    }
  }

 private:
  using Scalar = Eigen::Matrix<double, 1, 1>;

  [[nodiscard]] double command(double t, std::int64_t k, const Vector4d& x, const Scalar& memory) const {
    return law_ ? law_->command(x, memory, reference_.at(k, t).head<1>())[0] : std::sin(t);
  }
  [[nodiscard]] Scalar memory_rate(double t, std::int64_t k, const Vector4d& x, const Scalar& memory) const {
    return law_ ? law_->memory_rate(x, memory, reference_.at(k, t).head<1>()) : Scalar::Zero();
  }

  void ideal() {
    using Both = Eigen::Matrix<double, 5, 1>;
    for (std::int64_t k = 0; k < steps_of(run_); ++k) {
      const double t0 = static_cast<double>(k) * kStep;
      show(k, x_, x_[2], command(t0, k, x_, memory_));
      const auto rate = [&](double t, const Both& both) {
        const Vector4d x = both.head<4>();
        const Scalar memory = both.tail<1>();
        Both d;
        d << pendulum_.rate(x, command(t, k, x, memory)), memory_rate(t, k, x, memory);
        return d;
      };
      Both both;
      both << x_, memory_;
      both = math::rk4_step(rate, t0, both, kStep);
      x_ = both.head<4>();
      memory_ = both.tail<1>();
    }
  }

  template <class Filter>
  void sampled(Filter filter) {
    Noise noise(run_);
    const Eigen::Vector2d variances = estimator::ThesisFilter4Config{}.measurement_variance;
    for (std::int64_t k = 0; k < steps_of(run_); ++k) {
      const double t0 = static_cast<double>(k) * kStep;
      const Eigen::Vector2d measured = noise.on(Eigen::Vector2d(x_[0], x_[2]), variances);
      filter.update(measured);
      const Vector4d seen = filter.state().x;
      const double u = command(t0, k, seen, memory_);
      show(k, seen, measured[1], u);
      memory_ += kStep * memory_rate(t0, k, seen, memory_);
      x_ = math::rk4_step([&](double, const Vector4d& x) { return pendulum_.rate(x, u); }, t0, x_, kStep);
      filter.predict(u);
    }
  }

  static State in_space(const Vector4d& x) {
    State s = State::Zero();
    s[0] = x[0], s[3] = x[1], s[6] = x[2], s[8] = x[3];
    return s;
  }

  void show(std::int64_t k, const Vector4d& estimate, double angle_measured, double u) const {
    const Vector3d set = reference_.at(k, static_cast<double>(k) * kStep);
    const double L = pendulum_.length_m();
    const Vector3d p_WT(x_[0], 0, 0);
    observer_({k,
               in_space(x_),
               {in_space(estimate), Eigen::Vector2d(angle_measured, 0)},
               set,
               Vector3d(u, 0, 0),
               p_WT,
               p_WT + L * Vector3d(std::sin(x_[2]), 0, -std::cos(x_[2])),
               set,
               set - L * Vector3d::UnitZ(),
               L,
               0.0});
  }

  const Run& run_;
  const Observer& observer_;
  Reference reference_;
  plant::ThesisPendulum pendulum_;
  std::unique_ptr<controller::ThesisPendulumLaw> law_;
  Vector4d x_ = Vector4d::Zero();
  Scalar memory_ = Scalar::Zero();
};

}  // namespace

Vector3d home_m() {
  return {0.35 + 1.4922 + 0.210 + 0.567, 0.0, 0.83 + 1.16 + 0.25};
}

void simulate(const Run& run, const Observer& observer) {
  if (run.scenario->system == System::pendulum) {
    PendulumRun(run, observer).go();
  } else {
    CraneRun(run, observer).go();
  }
}

}  // namespace motionlab::thesis
