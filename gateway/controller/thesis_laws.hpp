/// @file  The control laws of the thesis: how the tool point should be accelerated.
#pragma once

#include <Eigen/Core>

#include "gateway/controller/thesis_gains.hpp"

namespace motionlab::controller {

/// A law on a state of `N` numbers with `M` inputs. Positions, in state and reference, are deviations from
/// where the run began: an integrator that starts at zero far from its origin would ask for 156 m/s² at once.
///
/// The law's own memory (integrals, filters) lives with the caller, so that one law serves both a continuous
/// simulation, in which the memory is integrated with the plant, and a sampled loop. It begins at zero. Laws
/// without memory leave it alone. Nothing is allocated.
template <int N, int M, int Memories>
class ThesisLaw {
 public:
  using State = Eigen::Matrix<double, N, 1>;
  using Input = Eigen::Matrix<double, M, 1>;
  using Memory = Eigen::Matrix<double, Memories, 1>;

  virtual ~ThesisLaw() = default;
  /// The acceleration to apply [m/s²].
  [[nodiscard]] virtual Input command(const State& x, const Memory& memory, const Input& reference) const = 0;
  /// d/dt of the memory.
  [[nodiscard]] virtual Memory memory_rate(const State& x, const Memory& memory,
                                           const Input& reference) const {
    (void)x, (void)memory, (void)reference;
    return Memory::Zero();
  }

 protected:
  ThesisLaw() = default;
  ThesisLaw(const ThesisLaw&) = default;
  ThesisLaw& operator=(const ThesisLaw&) = default;
};

// ---- The pendulum in a plane: state (x, x', theta, theta'), input x'' ----

using ThesisPendulumLaw = ThesisLaw<4, 1, 1>;

/// State feedback with pre-filter (Eq 4.26).
class ThesisPendulumPrefilter final : public ThesisPendulumLaw {
 public:
  explicit ThesisPendulumPrefilter(const ThesisPendulumPrefilterGain& gain) : gain_(gain) {}
  [[nodiscard]] Input command(const State& x, const Memory& memory, const Input& reference) const override;

 private:
  ThesisPendulumPrefilterGain gain_;
};

/// State feedback with integral (Eq 4.28–4.36). Memory: z = ∫ (x − r).
class ThesisPendulumIntegral final : public ThesisPendulumLaw {
 public:
  explicit ThesisPendulumIntegral(const ThesisPendulumIntegralGain& gain) : gain_(gain) {}
  [[nodiscard]] Input command(const State& x, const Memory& memory, const Input& reference) const override;
  [[nodiscard]] Memory memory_rate(const State& x, const Memory& memory,
                                   const Input& reference) const override;

 private:
  ThesisPendulumIntegralGain gain_;
};

struct ThesisPendulumDamperConfig {
  double damping_per_s = 5.0;  ///< d
  double wire_length_m = 2.0;
  double position_gain = 0.2;
  double speed_gain = 0.85;
};

/// Virtual damper with PD position control: x'' = +L d theta' / cos theta + Kp (r − x) − Kd x'. Eq 4.39/4.40
/// print the damper with a minus, which is unstable (poles +2.38 ± 1.49i).
class ThesisPendulumDamper final : public ThesisPendulumLaw {
 public:
  explicit ThesisPendulumDamper(const ThesisPendulumDamperConfig& config = {}) : config_(config) {}
  [[nodiscard]] Input command(const State& x, const Memory& memory, const Input& reference) const override;

 private:
  ThesisPendulumDamperConfig config_;
};

// ---- The load below the arm: state (tool point, velocity, swing angles, rates), input acceleration ----

using ThesisLoadLaw = ThesisLaw<10, 3, 4>;

/// Nothing is asked.
class ThesisLoadRest final : public ThesisLoadLaw {
 public:
  [[nodiscard]] Input command(const State&, const Memory&, const Input&) const override {
    return Input::Zero();
  }
};

/// State feedback with pre-filter (FPF, Eq 4.61).
class ThesisLoadPrefilter final : public ThesisLoadLaw {
 public:
  explicit ThesisLoadPrefilter(const ThesisLoadPrefilterGain& gain) : gain_(gain) {}
  [[nodiscard]] Input command(const State& x, const Memory& memory, const Input& reference) const override;

 private:
  ThesisLoadPrefilterGain gain_;
};

/// State feedback with integral (IC, Eq 4.65 and 4.88). Memory: z = ∫ (p − r), and a zero.
class ThesisLoadIntegral final : public ThesisLoadLaw {
 public:
  explicit ThesisLoadIntegral(const ThesisLoadIntegralGain& gain) : gain_(gain) {}
  [[nodiscard]] Input command(const State& x, const Memory& memory, const Input& reference) const override;
  [[nodiscard]] Memory memory_rate(const State& x, const Memory& memory,
                                   const Input& reference) const override;

 private:
  ThesisLoadIntegralGain gain_;
};

/// Tab 4.5 and Sec 4.5.5; each pair is (x, y).
struct ThesisLoadDamperConfig {
  Eigen::Vector2d damping_per_s{7, 5};
  double wire_length_m = 2.0;  ///< the damper's belief, whatever hangs there
  Eigen::Vector2d speed_gain{4.786, 1.002};
  Eigen::Vector2d speed_derivative_gain{3.324, 0.408};
  Eigen::Vector2d position_gain{0.577, 0.788};
  Eigen::Vector2d position_integral_gain{0.103, 0.072};
  double derivative_filter_radps = 100;  ///< N of a PID block; the thesis shows the cascade as a picture only
};

/// Virtual dampers (NL, Eq 4.73/4.74) with a cascade: PI on position, PD on speed. Height is not controlled.
/// Memory: ∫ of the position error (2), state of the derivative filter (2).
class ThesisLoadDamper final : public ThesisLoadLaw {
 public:
  explicit ThesisLoadDamper(const ThesisLoadDamperConfig& config = {}) : config_(config) {}
  [[nodiscard]] Input command(const State& x, const Memory& memory, const Input& reference) const override;
  [[nodiscard]] Memory memory_rate(const State& x, const Memory& memory,
                                   const Input& reference) const override;

 private:
  [[nodiscard]] Eigen::Vector2d speed_error(const State& x, const Memory& memory,
                                            const Input& reference) const;
  ThesisLoadDamperConfig config_;
};

}  // namespace motionlab::controller
