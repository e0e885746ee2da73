#include "simulators/mru/mru_device.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace motionlab::mru {
namespace {

constexpr std::size_t kMaxWaiting = 256;
constexpr std::string_view kUnknownFault =
    "unknown fault; a motion reference unit knows: off stuck garbage wrong slow delayed intermittent silent "
    "unstable reduced freeze_time nan wrong_token bad_checksum oversize restart";
/// Behind an NMEA checksum stand CR and LF.
constexpr std::size_t kAfterChecksumOfText = 2;

bool is_text(Format format) {
  return format == Format::psxn || format == Format::prdid || format == Format::nmeap;
}

bool has_utc(Format format) {
  return format == Format::km_binary || format == Format::bin23;
}

/// Every value that is measured, off by the same amount.
Reading off_by(Reading reading, double error) {
  if (error == 0.0) return reading;
  for (auto* const values :
       {&reading.euler_heading_mru_rad, &reading.omega_mru_radps, &reading.v_mru_mps, &reading.a_mru_mps2,
        &reading.p_heading_origin_m, &reading.v_heading_origin_mps, &reading.a_heading_origin_mps2}) {
    for (double& value : *values) value += error;
  }
  reading.omega_down_radps += error;
  return reading;
}

}  // namespace

MruDevice::MruDevice(DeviceConfig config, DatagramOut& out)
    : config_(std::move(config)),
      out_(out),
      jitter_(config_.seed, config_.name + "/wire"),
      garbage_(config_.seed, config_.name + "/garbage") {
  waiting_.reserve(kMaxWaiting);
}

void MruDevice::measure(const Reading& reading, LabTime t_measured) {
  // Drawn in every period, so that switching a fault on moves nobody else's dice.
  const double jitter_draw = jitter_.uniform();
  if (common_.off()) {
    t_first_.reset();
    waiting_.clear();
    return;
  }
  if (!t_first_) t_first_ = t_measured;
  ++measured_;
  if (!common_.stuck()) {
    stuck_at_.reset();
  } else if (!stuck_at_) {
    stuck_at_ = reading;
  }
  const Motion motion = motion_of(off_by(stuck_at_.value_or(reading), common_.wrong_by()), t_measured);
  const Nanoseconds t_unit = unit_time(t_measured);
  const auto every = static_cast<std::uint64_t>(std::max(1.0, std::round(common_.slow_by())));
  if (faults_.silent || !common_.speaks(t_measured) || measured_ % every != 0) return;

  Layout layout = config_.layout;
  if (faults_.wrong_token) layout.token = static_cast<std::uint8_t>(layout.token + 1);
  Waiting waiting;
  const auto encoded = encode(motion, config_.format, layout, config_.checksum_rule, t_unit, waiting.bytes);
  if (!encoded) return;
  waiting.size = encoded->size();
  const LabTime t_due = t_measured +
                        from_seconds(config_.output_latency_s + config_.output_jitter_s * jitter_draw) +
                        common_.delay();
  // The unit's output is a queue: nothing overtakes in it.
  waiting.t_due = waiting_.empty() ? t_due : std::max(t_due, waiting_.back().t_due);
  spoil(waiting);
  enqueue(waiting);
}

Motion MruDevice::motion_of(const Reading& reading, LabTime t_measured) {
  const bool settling = t_measured - *t_first_ < from_seconds(config_.settling_s);
  Motion motion;
  motion.stable = !settling && !faults_.unstable;
  motion.reduced = faults_.reduced;
  motion.euler_heading_mru_rad = reading.euler_heading_mru_rad;
  motion.omega_mru_radps = reading.omega_mru_radps;
  motion.omega_down_radps = reading.omega_down_radps;
  motion.v_mru_mps = reading.v_mru_mps;
  motion.a_mru_mps2 = reading.a_mru_mps2;
  motion.p_heading_origin_m = reading.p_heading_origin_m;
  motion.v_heading_origin_mps = reading.v_heading_origin_mps;
  motion.a_heading_origin_mps2 = reading.a_heading_origin_mps2;
  motion.sensor_temperature_degc = reading.sensor_temperature_degc;
  if (faults_.nan) motion.euler_heading_mru_rad[0] = kNotTold;
  return motion;
}

Nanoseconds MruDevice::unit_time(LabTime t_measured) {
  if (faults_.freeze_time) return t_unit_;
  const Nanoseconds elapsed = t_measured - *t_first_;
  const Nanoseconds drift{
      std::llround(static_cast<double>(elapsed.count()) * config_.clock_drift_ppm * 1e-6)};
  const Nanoseconds start = has_utc(config_.format)
                                ? t_first_->time_since_epoch()
                                : Nanoseconds{std::chrono::milliseconds{config_.system_time_start_ms}};
  t_unit_ = start + elapsed + drift + clock_jump_;
  return t_unit_;
}

void MruDevice::spoil(Waiting& waiting) {
  if (faults_.bad_checksum) {
    const std::size_t behind = is_text(config_.format) ? kAfterChecksumOfText : 0;
    waiting.bytes[waiting.size - 1 - behind] ^= 0x01;
  }
  if (common_.garbage()) {
    for (auto& byte : MutableBytes{waiting.bytes}.first(waiting.size)) {
      byte = static_cast<std::uint8_t>(garbage_.bits());
    }
  }
  waiting.size += faults_.oversize_bytes;
}

void MruDevice::enqueue(const Waiting& waiting) {
  if (waiting_.size() == kMaxWaiting) waiting_.erase(waiting_.begin());
  waiting_.push_back(waiting);
}

void MruDevice::step(LabTime now) {
  while (!waiting_.empty() && waiting_.front().t_due <= now) {
    const Waiting& next = waiting_.front();
    const Status status = out_.send(config_.to, Bytes{next.bytes.data(), next.size});
    ++(status ? sent_ : send_faults_);
    waiting_.erase(waiting_.begin());
  }
}

std::optional<LabTime> MruDevice::next_send() const noexcept {
  return waiting_.empty() ? std::nullopt : std::optional{waiting_.front().t_due};
}

bool MruDevice::can_have(std::string_view fault) const noexcept {
  const Format format = config_.format;
  if (fault == "wrong_token") return has_list(format);
  if (fault == "unstable") return format != Format::em1000 && format != Format::prdid;
  if (fault == "reduced") {
    return has_utc(format) || format == Format::em3000 || format == Format::psxn;
  }
  if (fault == "freeze_time") {
    return has_utc(format) || (has_list(format) && config_.layout.variables.index_of(Variable::system_time));
  }
  if (fault == "bad_checksum") {
    return format == Format::mrubin || format == Format::bin23 || is_text(format);
  }
  return true;
}

std::string_view MruDevice::fault_names() noexcept {
  return kUnknownFault.substr(kUnknownFault.find(':') + 2);
}

Status MruDevice::set_fault(std::string_view name, bool active, double value) {
  if (active && !can_have(name)) {
    return Fault{Reason::refused,
                 "the unit's format has nothing that could fail in this way: it lacks the time, status, "
                 "token or checksum"};
  }
  if (common_.set(name, active, value)) return Done{};
  if (name == "silent") {
    faults_.silent = active;
  } else if (name == "unstable") {
    faults_.unstable = active;
  } else if (name == "reduced") {
    faults_.reduced = active;
  } else if (name == "freeze_time") {
    faults_.freeze_time = active;
  } else if (name == "nan") {
    faults_.nan = active;
  } else if (name == "wrong_token") {
    faults_.wrong_token = active;
  } else if (name == "bad_checksum") {
    faults_.bad_checksum = active;
  } else if (name == "oversize") {
    const double bytes = std::clamp(value, 1.0, static_cast<double>(kMaxExtraBytes));
    faults_.oversize_bytes = active ? static_cast<std::size_t>(bytes) : 0;
  } else if (name == "restart") {
    if (active) t_first_.reset();
  } else {
    return Fault{Reason::refused, kUnknownFault};
  }
  return Done{};
}

}  // namespace motionlab::mru
