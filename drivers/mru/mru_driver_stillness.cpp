#include "drivers/mru/mru_driver_stillness.hpp"

#include <algorithm>
#include <cmath>

namespace motionlab::mru {
namespace {

bool same(const Motion::Triple& a, const Motion::Triple& b) noexcept {
  return std::ranges::equal(a, b,
                            [](double x, double y) { return x == y || (std::isnan(x) && std::isnan(y)); });
}

/// What a unit measures; its time and its temperature may go on.
bool same(const Motion& a, const Motion& b) noexcept {
  return same(a.euler_heading_mru_rad, b.euler_heading_mru_rad) &&
         same(a.omega_mru_radps, b.omega_mru_radps) && same(a.v_mru_mps, b.v_mru_mps) &&
         same(a.a_mru_mps2, b.a_mru_mps2) && same(a.p_heading_origin_m, b.p_heading_origin_m) &&
         same(a.v_heading_origin_mps, b.v_heading_origin_mps) &&
         same(a.a_heading_origin_mps2, b.a_heading_origin_mps2);
}

}  // namespace

bool Stillness::stuck(const Motion& motion, LabTime t_received) noexcept {
  if (limit_ <= Nanoseconds{0}) return false;
  if (!last_ || !same(motion, *last_)) moved_ = t_received;
  last_ = motion;
  return t_received - moved_ > limit_;
}

}  // namespace motionlab::mru
