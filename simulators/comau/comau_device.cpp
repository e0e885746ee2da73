#include "simulators/comau/comau_device.hpp"

#include <algorithm>
#include <limits>

namespace motionlab::comau {
namespace {

constexpr std::size_t kMaxLate = 256;
constexpr int kMaxExtraBytes = 64;

SetPoint::Config set_point_config(const DeviceConfig& config) {
  return {.q_min_rad = config.q_min_rad,
          .q_max_rad = config.q_max_rad,
          .qd_max_radps = config.qd_max_radps,
          .deceleration_radps2 = config.deceleration_radps2};
}

bool asks_to_follow(const Command& command) noexcept {
  return command.key == kKey && command.mode == static_cast<std::int32_t>(Mode::follow);
}

Joints wanted(const Command& command) noexcept {
  Joints qd;
  std::ranges::copy(command.qd_radps, qd.begin());
  return qd;
}

}  // namespace

ComauDevice::ComauDevice(DeviceConfig config, DatagramOut& out)
    : config_(config),
      out_(out),
      random_(config.seed, "comau/wire"),
      set_point_(set_point_config(config)),
      frame_counter_(config.frame_counter_start) {
  late_.reserve(kMaxLate);
}

void ComauDevice::on_datagram(Bytes datagram, Endpoint from, LabTime t_received) {
  const bool lost = random_.chance(loss_share_);
  if (crashed_ || silent_ || lost) return;
  const bool taken = config_.hardened ? take_hardened(datagram, from) : take_faithful(datagram);
  if (!taken) return;
  t_command_ = t_received;
  health_.accepted(t_received, t_received);
  answer(from, t_received);
}

bool ComauDevice::take_faithful(Bytes datagram) noexcept {
  std::copy_n(datagram.begin(), std::min(datagram.size(), buffer_.size()), buffer_.begin());
  return true;
}

bool ComauDevice::take_hardened(Bytes datagram, Endpoint from) {
  if (config_.peer.address != 0 &&
      (from.address != config_.peer.address || (config_.peer.port != 0 && from.port != config_.peer.port))) {
    health_.rejected({Reason::foreign, "a command from somebody who is not the configured peer"});
    return false;
  }
  const auto command = decode_command(datagram);
  if (!command) {
    health_.rejected(command.fault());
    return false;
  }
  if (const Status acceptable = check(*command); !acceptable) {
    health_.rejected(acceptable.fault());
    return false;
  }
  std::ranges::copy(datagram, buffer_.begin());
  return true;
}

void ComauDevice::answer(Endpoint to, LabTime t) {
  Answer said = measured_;
  said.frame_counter = frame_counter_;
  if (nan_answer_) said.q_rad[0] = std::numeric_limits<double>::quiet_NaN();
  const auto encoded = encode(said);
  Late datagram;
  std::ranges::copy(encoded, datagram.bytes.begin());
  datagram.size = static_cast<std::size_t>(static_cast<int>(kAnswerSize) + extra_bytes_);
  datagram.to = to;
  datagram.t_due = t + from_seconds(late_s_);
  if (late_s_ > 0.0) {
    if (late_.size() < kMaxLate) late_.push_back(datagram);
    return;
  }
  if (const Status status = out_.send(to, Bytes{datagram.bytes}.first(datagram.size)); !status) {
    health_.rejected(status.fault());
  }
}

void ComauDevice::send_late(LabTime t) {
  while (!late_.empty() && late_.front().t_due <= t) {
    const Late& first = late_.front();
    if (const Status status = out_.send(first.to, Bytes{first.bytes}.first(first.size)); !status) {
      health_.rejected(status.fault());
    }
    late_.erase(late_.begin());
  }
}

void ComauDevice::cycle(LabTime t, const Joints& q_measured_rad, const Joints& qd_measured_radps) {
  if (crashed_) return;
  if (!t_first_cycle_) {
    t_first_cycle_ = t;
    set_point_.synchronise(q_measured_rad);
  }
  if (!freeze_counter_) ++frame_counter_;
  measured_.q_rad = q_measured_rad;
  measured_.qd_radps = qd_measured_radps;
  send_late(t);

  const bool remote = t - *t_first_cycle_ >= from_seconds(config_.remote_enabled_after_s);
  if (!remote || drives_off_) {
    following_ = false;
    set_point_.synchronise(q_measured_rad);
  } else if (config_.hardened) {
    move_hardened(t, q_measured_rad);
  } else if (!t_command_) {
    crashed_ = true;
  } else {
    move_faithful(q_measured_rad);
  }
}

void ComauDevice::move_faithful(const Joints& q_measured_rad) {
  const Command command = decode_command(buffer_).value();
  following_ = asks_to_follow(command);
  if (following_) {
    set_point_.integrate(wanted(command));
  } else {
    set_point_.synchronise(q_measured_rad);
  }
}

void ComauDevice::move_hardened(LabTime t, const Joints& q_measured_rad) {
  const Command command = decode_command(buffer_).value();
  const bool wants = t_command_ && asks_to_follow(command);
  const bool stale = wants && t - *t_command_ > from_seconds(config_.command_age_max_s);
  if (stale) ++stale_cycles_;
  following_ = wants && !stale;
  if (following_) {
    set_point_.integrate(wanted(command));
  } else if (stale || !set_point_.at_rest()) {
    set_point_.integrate(set_point_.slowed(config_.stop_deceleration_radps2));
  } else {
    set_point_.synchronise(q_measured_rad);
  }
}

Status ComauDevice::set_fault(std::string_view name, bool active, double value) {
  if (name == "silent") {
    silent_ = active;
  } else if (name == "freeze_counter") {
    freeze_counter_ = active;
  } else if (name == "late") {
    late_s_ = active ? (value > 0.0 ? value : 0.05) : 0.0;
  } else if (name == "loss") {
    loss_share_ = active ? (value > 0.0 ? value : 0.1) : 0.0;
  } else if (name == "wrong_size") {
    const double bytes = std::clamp(value == 0.0 ? -1.0 : value, -1.0 * kAnswerSize, 1.0 * kMaxExtraBytes);
    extra_bytes_ = active ? static_cast<int>(bytes) : 0;
  } else if (name == "nan_answer") {
    nan_answer_ = active;
  } else if (name == "drive_off") {
    drives_off_ = active;
  } else {
    return Fault{
        Reason::refused,
        "unknown fault; the robot computer knows: silent freeze_counter late loss wrong_size nan_answer "
        "drive_off"};
  }
  return Done{};
}

}  // namespace motionlab::comau
