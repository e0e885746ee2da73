#include "simulators/lab/gust.hpp"

#include <charconv>
#include <cmath>
#include <numbers>

namespace motionlab::lab {

Status Gust::set(std::string_view fault, bool active, double value) {
  const Fault refused{Reason::refused, "the world knows gust and gust:DEGREES, the value is its force in N"};
  double degrees = 0;
  if (!fault.starts_with(kName)) return refused;
  if (fault.size() > kName.size()) {
    const std::string_view turned = fault.substr(kName.size() + 1);
    const auto [end, error] = std::from_chars(turned.data(), turned.data() + turned.size(), degrees);
    if (fault[kName.size()] != ':' || error != std::errc{} || end != turned.data() + turned.size() ||
        !std::isfinite(degrees)) {
      return refused;
    }
  }
  const double force_n = !active ? 0.0 : value == 0 ? kDefault_n : value;
  const double heading = degrees * std::numbers::pi / 180;
  force_n_ = force_n * Eigen::Vector3d(std::cos(heading), std::sin(heading), 0);
  return Done{};
}

}  // namespace motionlab::lab
