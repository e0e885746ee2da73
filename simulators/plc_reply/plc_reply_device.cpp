#include "simulators/plc_reply/plc_reply_device.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace motionlab::plc_reply {
namespace {

constexpr Nanoseconds kControlLasts = 500ms;
constexpr std::size_t kMaxLate = 256;
constexpr std::string_view kUnknownFault =
    "unknown fault; the PLC's remote interface knows: off stuck garbage wrong slow delayed intermittent "
    "silent nan wrong_size";

void add(Six& values, double error) noexcept {
  for (double& value : values) value += error;
}

}  // namespace

PlcReplyDevice::PlcReplyDevice(DeviceConfig config, DatagramOut& out)
    : config_(config), out_(out), garbage_(config.seed, "plc_reply/garbage") {}

void PlcReplyDevice::on_datagram(Bytes datagram, Endpoint, LabTime t_received) {
  if (common_.off() || silent_) return;
  const Result<Request> request = decode_request(datagram);
  if (!request) {
    health_.rejected(request.fault());
    return;
  }
  health_.accepted(t_received, t_received);
  ++waiting_;
  if (request->key != kControlKey) return;
  if (heartbeat_ && *heartbeat_ != request->heartbeat) t_heartbeat_ = t_received;
  heartbeat_ = request->heartbeat;
}

bool PlcReplyDevice::controlled(LabTime now) const noexcept {
  return t_heartbeat_ && now - *t_heartbeat_ < kControlLasts;
}

void PlcReplyDevice::hear(std::size_t unit, const MruFeedback& said, LabTime t_arrives) {
  inbox_[unit].push_back({said, t_arrives});
}

void PlcReplyDevice::cycle(LabTime t, const std::array<PlatformFeedback, 2>& platforms) {
  for (std::size_t unit = 0; unit < inbox_.size(); ++unit) {
    auto& inbox = inbox_[unit];
    for (; !inbox.empty() && inbox.front().t_arrives <= t; inbox.pop_front()) {
      if (!common_.off() && !common_.stuck()) known_.mrus[unit] = inbox.front().said;
    }
  }
  if (common_.off()) return;
  ++cycles_;
  for (; waiting_ > 0; --waiting_) answer(t);
  if (!common_.stuck()) known_.platforms = platforms;
}

Reply PlcReplyDevice::what_it_says() const noexcept {
  Reply reply = known_;
  reply.t_s = static_cast<double>(cycles_) * config_.task_period_s + seconds(clock_jump_);
  for (std::size_t ship = 0; ship < reply.platforms.size(); ++ship) {
    add(reply.platforms[ship].eta, common_.wrong_by());
    add(reply.mrus[ship].eta, common_.wrong_by());
    add(reply.mrus[ship].v, common_.wrong_by());
  }
  if (nan_) reply.platforms[0].eta[2] = std::numeric_limits<double>::quiet_NaN();
  return reply;
}

void PlcReplyDevice::answer(LabTime t) {
  ++unanswered_;
  if (!common_.speaks(t) || static_cast<double>(unanswered_) < std::round(common_.slow_by())) return;
  unanswered_ = 0;
  Late reply{.t_due = t + common_.delay(),
             .size = static_cast<std::size_t>(static_cast<int>(kReplySize) + extra_bytes_)};
  std::ranges::copy(encode(what_it_says()), reply.bytes.begin());
  if (common_.garbage()) {
    for (auto& byte : reply.bytes) byte = static_cast<std::uint8_t>(garbage_.bits());
  }
  if (late_.size() < kMaxLate) late_.push_back(reply);
  step(t);
}

void PlcReplyDevice::step(LabTime now) {
  for (; !late_.empty() && late_.front().t_due <= now; late_.pop_front()) {
    const Status left = out_.send(config_.to, Bytes{late_.front().bytes}.first(late_.front().size));
    if (left) {
      ++sent_;
    } else {
      health_.rejected(left.fault());
    }
  }
}

std::string_view PlcReplyDevice::fault_names() noexcept {
  return kUnknownFault.substr(kUnknownFault.find(':') + 2);
}

Status PlcReplyDevice::set_fault(std::string_view name, bool active, double value) {
  if (common_.set(name, active, value)) {
    if (!common_.off()) return Done{};
    waiting_ = cycles_ = 0;
    known_ = {};
    late_.clear();
    heartbeat_.reset();
    t_heartbeat_.reset();
  } else if (name == "silent") {
    silent_ = active;
  } else if (name == "nan") {
    nan_ = active;
  } else if (name == "wrong_size") {
    const double bytes = std::clamp(value == 0.0 ? -1.0 : value, -1.0 * kReplySize, 1.0 * kMaxExtraBytes);
    extra_bytes_ = active ? static_cast<int>(bytes) : 0;
  } else {
    return Fault{Reason::refused, kUnknownFault};
  }
  return Done{};
}

}  // namespace motionlab::plc_reply
