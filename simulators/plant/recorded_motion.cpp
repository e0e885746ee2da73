#include "simulators/plant/recorded_motion.hpp"

#include <algorithm>
#include <utility>

namespace motionlab::plant {

RecordedMotion::RecordedMotion(std::vector<Sample> samples)
    : samples_(std::move(samples)), eta_ddot_(samples_.size(), Vector6d::Zero()) {
  const double start_s = samples_.front().t_s;
  for (Sample& sample : samples_) sample.t_s -= start_s;
  // Equal slopes on both sides of every inner sample: a tridiagonal system in the second derivatives, solved
  // by elimination downwards and substitution upwards.
  const std::size_t n = samples_.size();
  std::vector<double> upper(n, 0.0);
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double before = samples_[i].t_s - samples_[i - 1].t_s,
                 after = samples_[i + 1].t_s - samples_[i].t_s;
    const Vector6d bend =
        (samples_[i + 1].eta - samples_[i].eta) / after - (samples_[i].eta - samples_[i - 1].eta) / before;
    const double pivot = (before + after) / 3 - before / 6 * upper[i - 1];
    upper[i] = after / 6 / pivot;
    eta_ddot_[i] = (bend - before / 6 * eta_ddot_[i - 1]) / pivot;
  }
  for (std::size_t i = n - 1; i-- > 1;) eta_ddot_[i] -= upper[i] * eta_ddot_[i + 1];
}

ShipCoordinates RecordedMotion::at(double t_s) const {
  if (t_s < 0) return {samples_.front().eta};
  if (t_s > duration_s()) return {samples_.back().eta};
  const auto later = std::upper_bound(samples_.begin() + 1, samples_.end() - 1, t_s,
                                      [](double t, const Sample& sample) { return t < sample.t_s; });
  const auto i = static_cast<std::size_t>(later - samples_.begin());
  const Sample &b = samples_[i - 1], &e = samples_[i];
  const double h = e.t_s - b.t_s, y = (t_s - b.t_s) / h, x = 1 - y;
  const Vector6d &cb = eta_ddot_[i - 1], &ce = eta_ddot_[i];
  return {x * b.eta + y * e.eta + h * h / 6 * ((x * x * x - x) * cb + (y * y * y - y) * ce),
          (e.eta - b.eta) / h + h / 6 * ((1 - 3 * x * x) * cb + (3 * y * y - 1) * ce), x * cb + y * ce};
}

}  // namespace motionlab::plant
