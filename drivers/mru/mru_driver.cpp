#include "drivers/mru/mru_driver.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <utility>

namespace motionlab::mru {
namespace {

DeviceClock::Config clock_config(const DriverConfig& config) {
  DeviceClock::Config clock;
  clock.latency = from_seconds(config.latency_s);
  clock.drift_ppm_max = config.drift_ppm_max;
  return clock;
}

}  // namespace

MruDriver::MruDriver(DriverConfig config, Sink<topic::Mru> sink)
    : config_(std::move(config)),
      sink_(std::move(sink)),
      judge_(config_.checksum),
      clock_(clock_config(config_)),
      system_time_(std::llround(config_.restart_gap_s * 1e3)) {
  sample_.device = config_.device;
  health_.phase(LinkPhase::connecting);
}

void MruDriver::on_datagram(Bytes datagram, Endpoint from, LabTime t_received) {
  if (config_.source_address != 0 && from.address != config_.source_address) {
    refuse({Reason::foreign, "a datagram from another address than the unit's: compare the address setting"},
           t_received);
    return;
  }
  const Result<Frame> frame = decode(datagram, config_.layout);
  if (!frame) {
    refuse(frame.fault(), t_received);
    return;
  }
  const ChecksumJudge::Verdict verdict = judge_.judge(frame->checksum_match);
  if (verdict == ChecksumJudge::Verdict::refuse) {
    refuse({Reason::bad_checksum, "the checksum does not match: the datagram was damaged on its way"},
           t_received);
    return;
  }
  const Result<LabTime> t_measured = place_in_time(*frame, t_received);
  if (!t_measured) {
    refuse(t_measured.fault(), t_received);
    return;
  }
  tell(*frame, verdict == ChecksumJudge::Verdict::suspect, *t_measured, t_received);
}

void MruDriver::refuse(Fault fault, LabTime t_received) noexcept {
  health_.rejected(fault);
  t_refused_ = t_received;
}

Result<LabTime> MruDriver::place_in_time(const Frame& frame, LabTime t_received) noexcept {
  using Step = WrappingCounter::Step;
  const auto raw_ms = frame.system_time_ms(config_.layout);
  if (!raw_ms) return t_received - from_seconds(config_.latency_s);

  Step step = system_time_.classify(*raw_ms);
  if (step == Step::repeated)
    return Fault{Reason::duplicate, "SystemTime has not moved: repeated, or the unit hangs"};
  if (step == Step::backward)
    return Fault{Reason::out_of_order, "SystemTime is older than the last accepted one"};
  if (step == Step::forward && health_.t_received()) {
    // Time may pass unseen, but the unit's cannot run ahead of ours: a restart can also look like a step
    // forward.
    const double ahead_s =
        1e-3 * static_cast<double>(system_time_.unwrapped(*raw_ms) - system_time_.total()) -
        seconds(t_received - *health_.t_received());
    if (ahead_s > config_.restart_gap_s) step = Step::restarted;
  }
  if (step == Step::restarted) {
    system_time_.reset();
    clock_.reset();
    health_.reconnected();
  }
  const std::int64_t advance_ms = system_time_.advance(*raw_ms);
  if (step == Step::forward) {
    const long long periods = std::llround(1e-3 * static_cast<double>(advance_ms) / config_.period_s);
    health_.lost(static_cast<std::uint64_t>(std::max(0LL, periods - 1)));
  }
  return clock_.map(std::chrono::milliseconds{system_time_.total()}, t_received);
}

void MruDriver::tell(const Frame& frame, bool suspect, LabTime t_measured, LabTime t_received) {
  const auto value = [&](Variable variable) {
    return frame.value(variable, config_.layout).value_or(std::numeric_limits<double>::quiet_NaN());
  };
  const auto triple = [&](Variable a, Variable b, Variable c) {
    return std::array<double, 3>{value(a), value(b), value(c)};
  };
  using enum Variable;
  health_.accepted(t_measured, t_received);
  health_.phase(LinkPhase::up);
  stable_ = frame.stable;
  ++sample_.sequence_number;
  sample_.t_measured_ns = to_ns(t_measured);
  sample_.t_received_ns = to_ns(t_received);
  sample_.stable = frame.stable;
  sample_.checksum_suspect = suspect;
  sample_.euler_heading_mru_rad = triple(roll, pitch, yaw);
  sample_.omega_mru_radps = triple(ang_rate_r, ang_rate_p, ang_rate_y);
  sample_.omega_down_radps = value(ang_rate_d);
  sample_.v_mru_mps = triple(vel_mru_r, vel_mru_p, vel_mru_y);
  sample_.a_mru_mps2 = triple(acc_mru_r, acc_mru_p, acc_mru_y);
  sample_.p_heading_origin_m = triple(pos_cg_f, pos_cg_s, pos_cg_d);
  sample_.v_heading_origin_mps = triple(vel_cg_f, vel_cg_s, vel_cg_d);
  sample_.a_heading_origin_mps2 = triple(acc_cg_f, acc_cg_s, acc_cg_d);
  sample_.sensor_temperature_degc = value(sensor_temperature);
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
      return "No good datagram from the unit: see the counted reasons; compare token, variable list and "
             "address.";
    }
    return health_.received() > 0
               ? "The unit has fallen silent: check its power, its cable and the network."
               : "Nothing has come from the unit yet: check its destination address and port.";
  }
  if (!stable_) return "The unit is settling: wait (about five minutes after power-on).";
  if (judge_.state() == ChecksumJudge::State::unknown) {
    return "The checksum follows neither known rule: record ten seconds of datagrams and settle the rule.";
  }
  return {};
}

}  // namespace motionlab::mru
