#include "simulators/mru/mru_device.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace motionlab::mru {
namespace {

constexpr std::size_t kMaxWaiting = 256;
constexpr std::size_t kMaxExtraBytes = 64;

double value_or(double value, double otherwise) {
  return value > 0.0 ? value : otherwise;
}

std::size_t bytes_or_one(double value, std::size_t most) {
  return value >= 1.0 ? static_cast<std::size_t>(std::min(value, static_cast<double>(most))) : 1;
}

}  // namespace

MruDevice::MruDevice(DeviceConfig config, DatagramOut& out)
    : config_(std::move(config)), out_(out), random_(config_.seed, config_.name + "/wire") {
  waiting_.reserve(kMaxWaiting);
}

void MruDevice::measure(const Reading& reading, LabTime t_measured) {
  if (!t_first_) t_first_ = t_measured;
  ++measured_;
  // Drawn in every period, so that switching a fault on moves nobody else's dice.
  const double jitter_draw = random_.uniform();
  const double loss_draw = random_.uniform();
  const double corrupt_draw = random_.uniform();
  const std::uint64_t corrupt_bits = random_.bits();

  const Frame frame = frame_of(reading, t_measured);
  if (faults_.silent || loss_draw < faults_.loss_share) return;

  Layout layout = config_.layout;
  if (faults_.wrong_token) layout.token = static_cast<std::uint8_t>(layout.token + 1);
  Waiting waiting;
  const auto encoded = encode(frame, layout, config_.checksum_rule, waiting.bytes);
  if (!encoded) return;
  waiting.size = encoded->size();
  waiting.order = measured_;
  if (corrupt_draw < faults_.corrupt_share) {
    const std::size_t bit = static_cast<std::size_t>(corrupt_bits % (8 * waiting.size));
    waiting.bytes[bit / 8] ^= static_cast<std::uint8_t>(1u << (bit % 8));
  }
  waiting.size -= std::min(waiting.size, faults_.truncate_bytes);
  waiting.size += faults_.oversize_bytes;

  double delay_s = config_.output_latency_s + config_.output_jitter_s * jitter_draw + faults_.late_s;
  if (faults_.reorder && measured_ % 2 == 0) delay_s += 1.5 * config_.period_s;
  waiting.t_due = t_measured + from_seconds(delay_s);
  enqueue(waiting);
  if (faults_.repeat) enqueue(waiting);
}

void MruDevice::enqueue(const Waiting& waiting) {
  if (waiting_.size() == kMaxWaiting) waiting_.erase(waiting_.begin());
  waiting_.push_back(waiting);
}

Frame MruDevice::frame_of(const Reading& reading, LabTime t_measured) {
  using enum Variable;
  Frame frame;
  const bool settling = t_measured - *t_first_ < from_seconds(config_.settling_s);
  frame.stable = !settling && !faults_.unstable;
  frame.token = config_.layout.token;
  frame.size = config_.layout.variables.size();
  const auto set = [&](Variable variable, double value) {
    if (const auto index = config_.layout.variables.index_of(variable)) frame.values[*index] = value;
  };
  const auto set_triple = [&](Variable a, Variable b, Variable c, const std::array<double, 3>& values) {
    set(a, values[0]);
    set(b, values[1]);
    set(c, values[2]);
  };
  set(system_time, static_cast<double>(system_time_ms(t_measured)));
  set(sensor_temperature, reading.sensor_temperature_degc);
  set(ang_rate_d, reading.omega_down_radps);
  set_triple(roll, pitch, yaw, reading.euler_heading_mru_rad);
  set_triple(ang_rate_r, ang_rate_p, ang_rate_y, reading.omega_mru_radps);
  set_triple(vel_mru_r, vel_mru_p, vel_mru_y, reading.v_mru_mps);
  set_triple(acc_mru_r, acc_mru_p, acc_mru_y, reading.a_mru_mps2);
  set_triple(pos_cg_f, pos_cg_s, pos_cg_d, reading.p_heading_origin_m);
  set_triple(vel_cg_f, vel_cg_s, vel_cg_d, reading.v_heading_origin_mps);
  set_triple(acc_cg_f, acc_cg_s, acc_cg_d, reading.a_heading_origin_mps2);
  if (faults_.nan) set(roll, std::numeric_limits<double>::quiet_NaN());
  return frame;
}

std::uint32_t MruDevice::system_time_ms(LabTime t_measured) {
  if (faults_.freeze_time) return last_system_time_ms_;
  const Nanoseconds elapsed = t_measured - *t_first_;
  const Nanoseconds drift{
      std::llround(static_cast<double>(elapsed.count()) * config_.clock_drift_ppm * 1e-6)};
  const auto elapsed_ms =
      std::chrono::floor<std::chrono::milliseconds>(elapsed + drift + clock_jump_).count();
  last_system_time_ms_ = static_cast<std::uint32_t>(config_.system_time_start_ms + elapsed_ms);
  return last_system_time_ms_;
}

void MruDevice::step(LabTime now) {
  const auto earlier = [](const Waiting& a, const Waiting& b) {
    return a.t_due != b.t_due ? a.t_due < b.t_due : a.order < b.order;
  };
  while (!waiting_.empty()) {
    const auto next = std::min_element(waiting_.begin(), waiting_.end(), earlier);
    if (next->t_due > now) return;
    const Status status = out_.send(config_.to, Bytes{next->bytes.data(), next->size});
    ++(status ? sent_ : send_faults_);
    waiting_.erase(next);
  }
}

std::optional<LabTime> MruDevice::next_send() const noexcept {
  std::optional<LabTime> next;
  for (const Waiting& waiting : waiting_) next = next ? std::min(*next, waiting.t_due) : waiting.t_due;
  return next;
}

Status MruDevice::set_fault(std::string_view name, bool active, double value) {
  if (name == "silent") {
    faults_.silent = active;
  } else if (name == "unstable") {
    faults_.unstable = active;
  } else if (name == "truncate") {
    faults_.truncate_bytes = active ? bytes_or_one(value, kMaxDatagram) : 0;
  } else if (name == "oversize") {
    faults_.oversize_bytes = active ? bytes_or_one(value, kMaxExtraBytes) : 0;
  } else if (name == "corrupt") {
    faults_.corrupt_share = active ? value_or(value, 1.0) : 0.0;
  } else if (name == "repeat") {
    faults_.repeat = active;
  } else if (name == "freeze_time") {
    faults_.freeze_time = active;
  } else if (name == "nan") {
    faults_.nan = active;
  } else if (name == "wrong_token") {
    faults_.wrong_token = active;
  } else if (name == "loss") {
    faults_.loss_share = active ? value_or(value, 0.1) : 0.0;
  } else if (name == "late") {
    faults_.late_s = active ? value_or(value, 0.05) : 0.0;
  } else if (name == "reorder") {
    faults_.reorder = active;
  } else if (name == "restart") {
    if (active) t_first_.reset();
  } else {
    return Fault{
        Reason::refused,
        "unknown fault; a motion reference unit knows: silent unstable truncate oversize corrupt repeat "
        "freeze_time nan wrong_token loss late reorder restart"};
  }
  return Done{};
}

}  // namespace motionlab::mru
