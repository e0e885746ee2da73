#include "simulators/comau/comau_device.hpp"

#include <algorithm>
#include <limits>

namespace motionlab::comau {
namespace {

constexpr std::size_t kMaxLate = 256;
/// The receiving thread of the faithful program holds its mutex so long for each datagram; assumed.
constexpr double kLockPerDatagram_s = 20e-6;

constexpr std::string_view kUnknownFault =
    "unknown fault; the robot computer knows: off stuck garbage wrong slow delayed intermittent silent "
    "freeze_counter wrong_size nan_answer powerlink_drop drive_off drive_fault hold local override torn";

SetPoint::Config set_point_config(const DeviceConfig& config) {
  return {.q_min_rad = config.q_min_rad,
          .q_max_rad = config.q_max_rad,
          .qd_max_radps = config.qd_max_radps,
          .deceleration_radps2 = config.deceleration_radps2};
}

bool asks_to_follow(const Command& command) noexcept {
  return command.key == kKey && command.mode == static_cast<std::int32_t>(Mode::follow);
}

}  // namespace

ComauDevice::ComauDevice(DeviceConfig config, DatagramOut& out)
    : config_(config),
      out_(out),
      random_(config.seed, "comau/garbage"),
      set_point_(set_point_config(config)),
      pendant_(config.pendant),
      frame_counter_(config.frame_counter_start) {
  late_.reserve(kMaxLate);
}

void ComauDevice::boot() noexcept {
  buffer_ = before_ = {};
  unread_ = following_ = listening_ = crashed_ = false;
  t_command_.reset();
  t_first_cycle_.reset();
  measured_ = {};
  frame_counter_ = config_.frame_counter_start;
  lock_owed_s_ = 0.0;
  late_.clear();
  pendant_.drop_powerlink(true);
  pendant_.drop_powerlink(false);
}

void ComauDevice::on_datagram(Bytes datagram, Endpoint from, LabTime t_received) {
  if (crashed_ || silent_ || faults_.off()) return;
  if (!config_.hardened) {
    take_faithful(datagram);
  } else if (!take_hardened(datagram, from)) {
    return;
  }
  t_command_ = t_received;
  health_.accepted(t_received, t_received);
  answer(from, t_received);
}

void ComauDevice::take_faithful(Bytes datagram) noexcept {
  before_ = buffer_;
  unread_ = true;
  std::copy_n(datagram.begin(), std::min(datagram.size(), buffer_.size()), buffer_.begin());
  lock_owed_s_ += kLockPerDatagram_s;
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

Answer ComauDevice::what_it_says() const noexcept {
  Answer said = stuck_.value_or(measured_);
  said.frame_counter = frame_counter_;
  for (std::size_t i = 0; i < kJointCount; ++i) {
    said.q_rad[i] += faults_.wrong_by();
    said.qd_radps[i] += faults_.wrong_by();
  }
  if (nan_answer_) said.q_rad[0] = std::numeric_limits<double>::quiet_NaN();
  if (config_.long_answers)
    said.limits = ReportedLimits{config_.q_min_rad, config_.q_max_rad, config_.qd_max_radps};
  return said;
}

void ComauDevice::answer(Endpoint to, LabTime t) {
  unanswered_ += 1.0;
  if (!faults_.speaks(t) || unanswered_ < faults_.slow_by()) return;
  unanswered_ = 0.0;
  const AnswerBytes encoded = encode(what_it_says());
  Late datagram;
  std::ranges::copy(encoded, datagram.bytes.begin());
  datagram.size = static_cast<std::size_t>(std::clamp(static_cast<int>(encoded.size()) + extra_bytes_, 0,
                                                      static_cast<int>(datagram.bytes.size())));
  if (faults_.garbage()) {
    for (auto& byte : datagram.bytes) byte = static_cast<std::uint8_t>(random_.bits());
  }
  datagram.to = to;
  datagram.t_due = t + faults_.delay();
  if (late_.size() < kMaxLate) late_.push_back(datagram);
  send_late(t);
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

bool ComauDevice::misses_cycle() noexcept {
  if (lock_owed_s_ <= kCycleSeconds) {
    lock_owed_s_ = 0.0;
    return false;
  }
  lock_owed_s_ -= kCycleSeconds;
  ++missed_cycles_;
  return true;
}

void ComauDevice::cycle(LabTime t, const Joints& q_measured_rad, const Joints& qd_measured_radps) {
  if (crashed_ || faults_.off()) return;
  send_late(t);
  if (!t_first_cycle_) {
    t_first_cycle_ = t;
    set_point_.synchronise(q_measured_rad);
  }
  pendant_.step(t);
  if (!pendant_.powerlink()) {
    following_ = listening_ = false;
    set_point_.synchronise(q_measured_rad);
    return;
  }
  if (misses_cycle()) return;
  if (!freeze_counter_) ++frame_counter_;
  measured_.q_rad = q_measured_rad;
  measured_.qd_radps = qd_measured_radps;
  move(t, q_measured_rad);
}

void ComauDevice::move(LabTime t, const Joints& q_measured_rad) {
  const bool was_listening = listening_;
  following_ = false;
  listening_ = drives_on() && pendant_.modality() == Pendant::Modality::listen;
  const bool remote = !local_ && t - *t_first_cycle_ >= from_seconds(config_.remote_enabled_after_s);
  if (!drives_on()) {
    set_point_.synchronise(q_measured_rad);
  } else if (listening_) {
    // The controller holds the arm where it found it.
    if (!was_listening) set_point_.synchronise(q_measured_rad);
  } else if (config_.hardened) {
    move_hardened(t, remote);
  } else {
    move_faithful(q_measured_rad, remote);
  }
}

Command ComauDevice::command_as_read() noexcept {
  Command32 read = buffer_;
  if (unread_)
    std::copy(before_.begin() + static_cast<std::ptrdiff_t>(torn_after_bytes_), before_.end(),
              read.begin() + static_cast<std::ptrdiff_t>(torn_after_bytes_));
  unread_ = false;
  return decode_command(read).value();
}

Joints ComauDevice::wanted(const Command& command) const noexcept {
  Joints qd;
  for (std::size_t i = 0; i < kJointCount; ++i) {
    qd[i] = pendant_.speed_share() * static_cast<double>(command.qd_radps[i]);
  }
  return qd;
}

void ComauDevice::move_faithful(const Joints& q_measured_rad, bool remote) {
  if (remote && !t_command_) {
    crashed_ = true;
    return;
  }
  const Command command = command_as_read();
  following_ = remote && asks_to_follow(command);
  if (following_) {
    set_point_.integrate(wanted(command));
  } else {
    set_point_.synchronise(q_measured_rad);
  }
}

void ComauDevice::move_hardened(LabTime t, bool remote) {
  const Command command = command_as_read();
  const bool wants = remote && t_command_ && asks_to_follow(command);
  const bool stale = wants && t - *t_command_ > from_seconds(config_.command_age_max_s);
  if (stale) ++stale_cycles_;
  following_ = wants && !stale;
  if (following_) {
    set_point_.integrate(set_point_.approached(wanted(command), config_.acceleration_max_radps2));
  } else if (!set_point_.at_rest()) {
    set_point_.integrate(set_point_.approached({}, config_.stop_deceleration_radps2));
  }
}

std::string_view ComauDevice::fault_names() noexcept {
  return kUnknownFault.substr(kUnknownFault.find(':') + 2);
}

Status ComauDevice::set_fault(std::string_view name, bool active, double value) {
  const bool was_off = faults_.off();
  if (faults_.set(name, active, value)) {
    if (faults_.off() != was_off) boot();
    if (name == "stuck") stuck_ = active ? std::optional(measured_) : std::nullopt;
  } else if (name == "silent") {
    silent_ = active;
  } else if (name == "freeze_counter") {
    freeze_counter_ = active;
  } else if (name == "wrong_size") {
    const double bytes =
        std::clamp(value == 0.0 ? -1.0 : value, -1.0 * kLongAnswerSize, 1.0 * kMaxExtraBytes);
    extra_bytes_ = active ? static_cast<int>(bytes) : 0;
  } else if (name == "nan_answer") {
    nan_answer_ = active;
  } else if (name == "powerlink_drop") {
    pendant_.drop_powerlink(active);
  } else if (name == "drive_off") {
    pendant_.press_drive_off(active);
  } else if (name == "drive_fault") {
    pendant_.fail_drives(active);
  } else if (name == "hold") {
    pendant_.press_hold(active);
  } else if (name == "local") {
    local_ = active;
  } else if (name == "override") {
    const double percent = std::clamp(value == 0.0 ? 20.0 : value, 1.0, 100.0);
    pendant_.set_override(active ? std::optional(percent) : std::nullopt);
  } else if (name == "torn" && config_.hardened) {
    return Fault{Reason::refused,
                 "torn is a fault of the faithful program; this one hands commands over whole"};
  } else if (name == "torn") {
    const double bytes = std::clamp(value == 0.0 ? 20.0 : value, 1.0, 1.0 * kCommandSize);
    torn_after_bytes_ = active ? static_cast<std::size_t>(bytes) : kCommandSize;
  } else {
    return Fault{Reason::refused, kUnknownFault};
  }
  return Done{};
}

}  // namespace motionlab::comau
