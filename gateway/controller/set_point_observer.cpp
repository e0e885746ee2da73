#include "gateway/controller/set_point_observer.hpp"

#include <algorithm>

namespace motionlab::controller {

SetPointObserver::SetPointObserver(const ServoBelief& servo, double gain_per_s,
                                   const ServoIdentifierConfig& identifier)
    : servo_(servo), gain_per_s_(gain_per_s), identifier_(servo, identifier) {
  for (auto& sent : ring_) sent.t = LabTime::min();
}

void SetPointObserver::sent(LabTime t, bool follow, const Vector3d& qd) {
  ring_[next_] = {t, follow, qd};
  next_ = (next_ + 1) % kCapacity;
}

Eigen::Vector3d SetPointObserver::integral(LabTime from, LabTime to) const {
  Vector3d sum = Vector3d::Zero();
  LabTime end = to;
  for (std::size_t back = 0; back < kCapacity && end > from; ++back) {
    const Sent& sent = ring_[(next_ + kCapacity - 1 - back) % kCapacity];
    const LabTime begin = std::max(from, sent.t);
    if (begin >= end) continue;
    if (sent.follow) sum += seconds(end - begin) * sent.qd;
    end = begin;
  }
  return sum;
}

bool SetPointObserver::following(LabTime from, LabTime to) const {
  LabTime end = to;
  for (std::size_t back = 0; back < kCapacity; ++back) {
    const Sent& sent = ring_[(next_ + kCapacity - 1 - back) % kCapacity];
    if (sent.t >= end) continue;
    if (!sent.follow) return false;
    if (sent.t <= from) return true;
    end = sent.t;
  }
  return false;
}

void SetPointObserver::step_servo(const Vector3d& set_point, double dt) {
  const Vector3d& w = omega_radps();
  const Vector3d qdd = w.cwiseProduct(w.cwiseProduct(set_point - q_) - 2 * servo_.zeta * qd_);
  q_ += dt * qd_ + 0.5 * dt * dt * qdd;
  qd_ += dt * qdd;
}

void SetPointObserver::measured(LabTime t, const Vector3d& q, const Vector3d& qd) {
  if ((heard_ && t <= t_) || !q.allFinite() || !qd.allFinite()) return;
  const LabTime t_set_point = t - from_seconds(servo_.delay_s);
  // After a silence longer than the ring remembers, or while the robot holds, there is nothing to integrate.
  if (!heard_ || t - t_ > 200ms || !following(t_set_point_, t_set_point)) {
    set_point_ = q_ = q;
    qd_ = qd;
    identifier_.restart(q, qd);
  } else {
    constexpr double kStep = 0.0005;
    const double span = seconds(t - t_);
    const int steps = std::max(1, static_cast<int>(span / kStep + 0.5));
    const Nanoseconds each = (t_set_point - t_set_point_) / steps;
    LabTime at = t_set_point_;
    for (int i = 0; i < steps; ++i) {
      const LabTime next = i + 1 == steps ? t_set_point : at + each;
      const Vector3d moved = integral(at, next);
      step_servo(set_point_ + 0.5 * moved, span / steps);
      identifier_.advance(moved, span / steps);
      set_point_ += moved;
      at = next;
    }
    set_point_ += gain_per_s_ * span * (q - q_);
    identifier_.measured(q, span);
  }
  heard_ = true;
  t_ = t;
  t_set_point_ = t_set_point;
}

Eigen::Vector3d SetPointObserver::at(LabTime t) const {
  return set_point_ + integral(t_set_point_, t);
}

}  // namespace motionlab::controller
