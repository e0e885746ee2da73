#include "gateway/controller/thesis_laws.hpp"

#include <cmath>

namespace motionlab::controller {

using Eigen::Vector2d;

ThesisPendulumLaw::Input ThesisPendulumPrefilter::command(const State& x, const Memory&,
                                                          const Input& r) const {
  return gain_.N * r - gain_.K * x;
}

ThesisPendulumLaw::Input ThesisPendulumIntegral::command(const State& x, const Memory& z,
                                                         const Input&) const {
  return -gain_.Kz * z - gain_.K * x;
}

ThesisPendulumLaw::Memory ThesisPendulumIntegral::memory_rate(const State& x, const Memory&,
                                                              const Input& r) const {
  return x.head<1>() - r;
}

ThesisPendulumLaw::Input ThesisPendulumDamper::command(const State& x, const Memory&, const Input& r) const {
  const double damper = config_.wire_length_m * config_.damping_per_s * x[3] / std::cos(x[2]);
  return Input(damper + config_.position_gain * (r[0] - x[0]) - config_.speed_gain * x[1]);
}

ThesisLoadLaw::Input ThesisLoadPrefilter::command(const State& x, const Memory&, const Input& r) const {
  return gain_.N * r - gain_.K * x;
}

ThesisLoadLaw::Input ThesisLoadIntegral::command(const State& x, const Memory& memory, const Input&) const {
  return -gain_.Kz * memory.head<3>() - gain_.K * x;
}

ThesisLoadLaw::Memory ThesisLoadIntegral::memory_rate(const State& x, const Memory&, const Input& r) const {
  Memory rate = Memory::Zero();
  rate.head<3>() = x.head<3>() - r;
  return rate;
}

Vector2d ThesisLoadDamper::speed_error(const State& x, const Memory& memory, const Input& r) const {
  const Vector2d error = r.head<2>() - x.head<2>();
  return config_.position_gain.cwiseProduct(error) +
         config_.position_integral_gain.cwiseProduct(memory.head<2>()) - x.segment<2>(3);
}

ThesisLoadLaw::Input ThesisLoadDamper::command(const State& x, const Memory& memory, const Input& r) const {
  const Vector2d error = speed_error(x, memory, r);
  const Vector2d derivative = config_.derivative_filter_radps * (error - memory.tail<2>());
  const Vector2d cascade =
      config_.speed_gain.cwiseProduct(error) + config_.speed_derivative_gain.cwiseProduct(derivative);
  const double ca = std::cos(x[6]), cb = std::cos(x[7]);
  const Vector2d damper =
      config_.wire_length_m * config_.damping_per_s.cwiseProduct(Vector2d(-x[8] / ca, x[9] * ca / cb));
  return {cascade[0] + damper[0], cascade[1] + damper[1], 0.0};
}

ThesisLoadLaw::Memory ThesisLoadDamper::memory_rate(const State& x, const Memory& memory,
                                                    const Input& r) const {
  Memory rate;
  rate.head<2>() = r.head<2>() - x.head<2>();
  rate.tail<2>() = config_.derivative_filter_radps * (speed_error(x, memory, r) - memory.tail<2>());
  return rate;
}

}  // namespace motionlab::controller
