#include "gateway/estimator/arm_history.hpp"

#include <algorithm>

namespace motionlab::estimator {
namespace {

/// Readings this far apart give the slope of the velocity: long against encoder noise, short against the
/// motion.
constexpr std::size_t kSlopeReadings = 2;

}  // namespace

void ArmHistory::add(LabTime t, const Eigen::Vector3d& q, const Eigen::Vector3d& qd) {
  if (count_ > 0 && t <= newest(0).t) return;
  ring_[next_] = {t, q, qd};
  next_ = (next_ + 1) % kCapacity;
  count_ = std::min(count_ + 1, kCapacity);
}

JointMotion ArmHistory::at(LabTime t) const {
  std::size_t back = 0;
  while (back + 1 < count_ && newest(back).t > t) ++back;
  const Reading& before = newest(back);
  const std::size_t late = back >= kSlopeReadings ? back - kSlopeReadings : 0;
  const std::size_t early = std::min(back + kSlopeReadings, count_ - 1);
  JointMotion motion;
  const double span = seconds(newest(late).t - newest(early).t);
  if (span > 0) motion.qdd = (newest(late).qd - newest(early).qd) / span;
  if (back == 0 || before.t > t) {
    const double ahead = std::clamp(seconds(t - before.t), 0.0, 0.05);
    motion.q = before.q + ahead * before.qd;
    motion.qd = before.qd;
    return motion;
  }
  const Reading& after = newest(back - 1);
  const double f = seconds(t - before.t) / seconds(after.t - before.t);
  motion.q = before.q + f * (after.q - before.q);
  motion.qd = before.qd + f * (after.qd - before.qd);
  return motion;
}

}  // namespace motionlab::estimator
