#include "simulators/plant/platform_limits.hpp"

#include <array>
#include <cmath>
#include <numbers>
#include <sstream>

namespace motionlab::plant {

namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kStep_s = 0.020;
/// A motion that only just touches a limit is within it, rounding included.
constexpr double kTouching = 1e-9;

Vector6d of(double surge, double sway, double heave, double roll_deg, double pitch_deg, double yaw_deg) {
  Vector6d v;
  v << surge, sway, heave, kDegree * roll_deg, kDegree * pitch_deg, kDegree * yaw_deg;
  return v;
}

}  // namespace

PlatformLimits PlatformLimits::mechanical() {
  return {"mechanical", of(-1.110, -1.333, -0.955, -26.10, -25.55, -31.10),
          of(1.333, 1.333, 0.885, 26.10, 33.40, 31.10), of(0.711, 0.711, 0.610, 20, 20, 20),
          of(0.60, 0.60, 0.80, 100, 100, 100)};
}

PlatformLimits PlatformLimits::plc() {
  PlatformLimits limits = mechanical();
  limits.name = "PLC's";
  limits.max = of(0.20, 0.20, 0.60, 5, 5, 10);
  limits.min = -limits.max;
  return limits;
}

std::optional<Excess> excess(const ShipMotion& motion, const PlatformLimits& limits, double until_s) {
  Excess worst{};
  double factor = 0;
  const auto look = [&](int c, Excess::Quantity quantity, double reached, double allowed, double t_s) {
    if (reached / allowed <= factor) return;
    factor = reached / allowed;
    worst = {c, quantity, reached, allowed, t_s, 1 / factor};
  };
  for (double t = 0; t <= until_s; t += kStep_s) {
    const ShipCoordinates s = motion.at(t);
    for (int c = 0; c < 6; ++c) {
      look(c, Excess::Quantity::position, s.eta[c], s.eta[c] < 0 ? limits.min[c] : limits.max[c], t);
      look(c, Excess::Quantity::speed, std::abs(s.eta_dot[c]), limits.speed[c], t);
      look(c, Excess::Quantity::acceleration, std::abs(s.eta_ddot[c]), limits.acceleration[c], t);
    }
  }
  if (factor <= 1 + kTouching) return std::nullopt;
  return worst;
}

std::string describe(const Excess& e, const PlatformLimits& limits) {
  constexpr std::array<std::string_view, 6> kNames{"surge", "sway", "heave", "roll", "pitch", "yaw"};
  constexpr std::array<std::string_view, 3> kPer{"", "/s", "/s²"};
  const bool angle = e.coordinate >= 3;
  const double unit = angle ? kDegree : 1.0;
  const std::string_view per = kPer[static_cast<std::size_t>(e.quantity)];
  std::ostringstream text;
  text.precision(3);
  text << kNames[static_cast<std::size_t>(e.coordinate)] << ": " << e.reached / unit << (angle ? "°" : " m")
       << per << " after " << e.t_s << " s, the " << limits.name << " limit is " << e.allowed / unit
       << (angle ? "°" : " m") << per;
  return text.str();
}

}  // namespace motionlab::plant
