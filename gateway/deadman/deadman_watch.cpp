#include "gateway/deadman/deadman_watch.hpp"

#include <algorithm>

namespace motionlab::deadman {

Nanoseconds DeadmanWatch::Pulse::look(std::uint64_t beats, Nanoseconds counted) noexcept {
  silent_ = beats == seen_ && beats > 0 ? silent_ + counted : 0ns;
  seen_ = beats;
  return silent_;
}

Verdict DeadmanWatch::look(LabTime now, const Sight& sight) noexcept {
  const Nanoseconds passed = t_looked_ ? now - *t_looked_ : 0ns;
  t_looked_ = now;
  if (sight.phase == Phase::ended) return Verdict::ended;
  if (sight.gone) return Verdict::gone;
  if (sight.phase == Phase::leaving) return Verdict::alive;
  const Nanoseconds counted = std::clamp(passed, Nanoseconds{0ns}, config_.look_period);
  const Nanoseconds io = io_.look(sight.io_beats, counted);
  const Nanoseconds control = control_.look(sight.control_beats, counted);
  if (io >= config_.io_silent_after) return Verdict::io_silent;
  if (control >= config_.control_silent_after) return Verdict::control_silent;
  return Verdict::alive;
}

}  // namespace motionlab::deadman
