#include "simulators/comau/comau_device_pendant.hpp"

namespace motionlab::comau {

void Pendant::step(LabTime t) noexcept {
  for (;;) {
    if (!since_) since_ = t;
    const auto following = next(seconds(t - *since_));
    if (!following) return;
    enter(*following);
  }
}

std::optional<Pendant::Phase> Pendant::next(double waited_s) const noexcept {
  const auto after = [waited_s](double due_s, Phase phase) {
    return waited_s >= due_s ? std::optional(phase) : std::nullopt;
  };
  switch (phase_) {
    case Phase::powerlink_down:
      return line_cut_ ? std::nullopt : after(config_.powerlink_after_s, Phase::drives_off);
    case Phase::drives_off:
      return off_pressed_ || drives_failed_ ? std::nullopt
                                            : after(config_.drive_on_after_s, Phase::driving_on);
    case Phase::driving_on:
      return after(config_.driving_on_s, Phase::listen);
    case Phase::listen:
      return held_ ? std::nullopt : after(config_.start_after_s, Phase::open);
    case Phase::driving_off:
      return after(config_.driving_off_s, Phase::drives_off);
    case Phase::open:
      break;
  }
  return std::nullopt;
}

Pendant::Drives Pendant::drives() const noexcept {
  switch (phase_) {
    case Phase::driving_on:
      return Drives::driving_on;
    case Phase::driving_off:
      return Drives::driving_off;
    case Phase::listen:
    case Phase::open:
      return Drives::on;
    case Phase::powerlink_down:
    case Phase::drives_off:
      break;
  }
  return Drives::off;
}

// Whoever waits for something to end waits from its end: entering a phase again begins its time again.

void Pendant::drop_powerlink(bool active) noexcept {
  line_cut_ = active;
  if (active || phase_ == Phase::powerlink_down) enter(Phase::powerlink_down);
}

void Pendant::press_drive_off(bool active) noexcept {
  off_pressed_ = active;
  if (active && (phase_ == Phase::driving_on || drives() == Drives::on)) enter(Phase::driving_off);
  if (!active && phase_ == Phase::drives_off) enter(Phase::drives_off);
}

void Pendant::fail_drives(bool active) noexcept {
  drives_failed_ = active;
  if (phase_ != Phase::powerlink_down && (active || phase_ == Phase::drives_off)) enter(Phase::drives_off);
}

void Pendant::press_hold(bool active) noexcept {
  held_ = active;
  if (phase_ == Phase::listen || (active && phase_ == Phase::open)) enter(Phase::listen);
}

}  // namespace motionlab::comau
