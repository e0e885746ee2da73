#include "gateway/controller/carried_place.hpp"

namespace motionlab::controller {

void CarriedPlace::step(double dt, bool carried) {
  double before = carried ? 1.0 : 0.0;
  for (double& stage : stage_) {
    const double was = stage;
    stage += dt / kLag_s * (before - stage);
    before = was;
  }
}

math::PointMotion CarriedPlace::motion(const math::PointMotion& p, const math::BodyMotion& ship) const {
  const double s = stage_[2], rate = (stage_[1] - stage_[2]) / kLag_s;
  const double rate_rate = ((stage_[0] - stage_[1]) / kLag_s - rate) / kLag_s;
  const math::PointMotion c = math::carried(ship, {X_NW_ * p.p, X_NW_.R * p.v, X_NW_.R * p.a});
  const math::Vector3d d = c.p - p.p, d_dot = c.v - p.v;
  return {p.p + s * d, p.v + s * d_dot + rate * d, p.a + s * (c.a - p.a) + 2 * rate * d_dot + rate_rate * d};
}

}  // namespace motionlab::controller
