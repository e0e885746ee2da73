#include "drivers/mru/mru_driver.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <utility>

namespace motionlab::mru {
namespace {

/// Coarse whole numbers stand still on a platform at rest; only floating-point ones show the sensor's noise.
bool shows_noise(Format format) noexcept {
  return format == Format::mrubin || format == Format::km_binary;
}

}  // namespace

MruDriver::MruDriver(DriverConfig config, Sink<topic::Mru> sink)
    : config_(std::move(config)),
      sink_(std::move(sink)),
      decoder_(config_.format, config_.layout),
      judge_(config_.checksum),
      stillness_(shows_noise(config_.format) ? from_seconds(config_.stuck_after_s) : 0s),
      clock_({.latency = from_seconds(config_.latency_s), .drift_ppm_max = config_.drift_ppm_max}),
      unit_time_ms_(std::llround(config_.restart_gap_s * 1e3)) {
  sample_.device = config_.device;
  health_.phase(LinkPhase::connecting);
}

void MruDriver::on_datagram(Bytes datagram, Endpoint from, LabTime t_received) {
  if (config_.source_address != 0 && from.address != config_.source_address) {
    refuse({Reason::foreign, "a datagram from another address than the unit's: compare the address setting"},
           t_received);
    return;
  }
  const Result<std::optional<Telegram>> telegram = decoder_.decode(datagram);
  if (!telegram) {
    refuse(telegram.fault(), t_received);
    return;
  }
  if (!*telegram) return;
  const auto& [motion, check] = **telegram;
  const ChecksumJudge::Verdict verdict = judge(check);
  if (verdict == ChecksumJudge::Verdict::refuse) {
    refuse({Reason::bad_checksum, "the checksum does not match: the datagram was damaged on its way"},
           t_received);
    return;
  }
  const Result<LabTime> t_measured = place_in_time(motion, t_received);
  if (!t_measured) {
    refuse(t_measured.fault(), t_received);
    return;
  }
  tell(motion, verdict == ChecksumJudge::Verdict::suspect, *t_measured, t_received);
}

ChecksumJudge::Verdict MruDriver::judge(const Check& check) noexcept {
  switch (check.rule) {
    case Check::Rule::none:
      break;
    case Check::Rule::known:
      return judge_.judge(check.good);
    case Check::Rule::unsettled:
      return judge_.judge(check.match);
  }
  return ChecksumJudge::Verdict::good;
}

void MruDriver::refuse(Fault fault, LabTime t_received) noexcept {
  health_.rejected(fault);
  t_refused_ = t_received;
}

Result<LabTime> MruDriver::place_in_time(const Motion& motion, LabTime t_received) noexcept {
  using Step = WrappingCounter::Step;
  if (!motion.t_unit) return t_received - from_seconds(config_.latency_s);

  const std::uint32_t raw_ms = motion.t_unit->ms;
  Step step = unit_time_ms_.classify(raw_ms);
  if (step == Step::repeated)
    return Fault{Reason::duplicate, "the unit's time has not moved: repeated, or the unit hangs"};
  if (step == Step::backward)
    return Fault{Reason::out_of_order, "the unit's time is older than the last accepted one"};
  if (step == Step::forward && health_.t_received()) {
    // Time may pass unseen, but the unit's cannot run ahead of ours: a restart can also look like a step
    // forward.
    const double ahead_s =
        1e-3 * static_cast<double>(unit_time_ms_.unwrapped(raw_ms) - unit_time_ms_.total()) -
        seconds(t_received - *health_.t_received());
    if (ahead_s > config_.restart_gap_s) step = Step::restarted;
  }
  if (step == Step::restarted) {
    unit_time_ms_.reset();
    clock_.reset();
    health_.reconnected();
  }
  const std::int64_t advance_ms = unit_time_ms_.advance(raw_ms);
  if (step == Step::forward) {
    const long long periods = std::llround(1e-3 * static_cast<double>(advance_ms) / config_.period_s);
    health_.lost(static_cast<std::uint64_t>(std::max(0LL, periods - 1)));
  }
  return clock_.map(std::chrono::milliseconds{unit_time_ms_.total()} + motion.t_unit->within_ms, t_received);
}

void MruDriver::tell(const Motion& motion, bool suspect, LabTime t_measured, LabTime t_received) {
  health_.accepted(t_measured, t_received);
  health_.phase(LinkPhase::up);
  stuck_ = stillness_.stuck(motion, t_received);
  stable_ = motion.stable;
  reduced_ = motion.reduced;
  ++sample_.sequence_number;
  sample_.t_measured_ns = to_ns(t_measured);
  sample_.t_received_ns = to_ns(t_received);
  sample_.stable = motion.stable && !stuck_;
  sample_.checksum_suspect = suspect;
  sample_.euler_heading_mru_rad = motion.euler_heading_mru_rad;
  sample_.omega_mru_radps = motion.omega_mru_radps;
  sample_.omega_down_radps = motion.omega_down_radps;
  sample_.v_mru_mps = motion.v_mru_mps;
  sample_.a_mru_mps2 = motion.a_mru_mps2;
  sample_.p_heading_origin_m = motion.p_heading_origin_m;
  sample_.v_heading_origin_mps = motion.v_heading_origin_mps;
  sample_.a_heading_origin_mps2 = motion.a_heading_origin_mps2;
  sample_.sensor_temperature_degc = motion.sensor_temperature_degc;
  if (sink_) sink_(sample_);
}

void MruDriver::step(LabTime now) {
  if (!t_started_) t_started_ = now;
  const LabTime t_last = health_.t_received().value_or(*t_started_);
  if (now - t_last > from_seconds(config_.silent_after_s)) {
    health_.phase(health_.received() > 0 ? LinkPhase::down : LinkPhase::connecting);
  }
  health_.advice(advice(now));
}

std::string_view MruDriver::advice(LabTime now) const noexcept {
  const LabTime t_last = health_.t_received().value_or(*t_started_);
  if (now - t_last > from_seconds(config_.silent_after_s)) {
    if (t_refused_ && now - *t_refused_ <= from_seconds(config_.silent_after_s)) {
      return "No good datagram from the unit: see the counted reasons; compare format, token, variable "
             "list and address.";
    }
    return health_.received() > 0
               ? "The unit has fallen silent: check its power, its cable and the network."
               : "Nothing has come from the unit yet: check its destination address and port.";
  }
  if (stuck_) return "The unit repeats its values to the last bit: it does not measure; power it off and on.";
  if (!stable_) return "The unit is settling: wait (about five minutes after power-on).";
  if (reduced_) return "The unit reports reduced performance: see its own status.";
  if (judge_.state() == ChecksumJudge::State::unknown) {
    return "The checksum follows neither known rule: record ten seconds of datagrams and settle the rule.";
  }
  return {};
}

}  // namespace motionlab::mru
