#include "drivers/plc_reply/plc_reply_driver.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace motionlab::plc_reply {
namespace {

constexpr double kNotTold = std::numeric_limits<double>::quiet_NaN();
constexpr std::array<std::string_view, 2> kShips{"em8000", "em1500"};
/// So many requests may be under way: one that the PLC answers in its next cycle, one just behind it.
constexpr std::uint64_t kUnderWay = 2;

std::array<double, 3> lengths(const Six& values) noexcept {
  return {values[0], values[1], values[2]};
}
std::array<double, 3> angles(const Six& values) noexcept {
  return {values[3], values[4], values[5]};
}

}  // namespace

std::array<double, 4> quaternion(double roll, double pitch, double yaw, EulerOrder order) noexcept {
  const double cx = std::cos(roll / 2), sx = std::sin(roll / 2);
  const double cy = std::cos(pitch / 2), sy = std::sin(pitch / 2);
  const double cz = std::cos(yaw / 2), sz = std::sin(yaw / 2);
  // The products of the three turns; the other order turns round where two axes meet.
  const double sign = order == EulerOrder::xyz ? 1.0 : -1.0;
  return {cx * cy * cz - sign * sx * sy * sz, sx * cy * cz + sign * cx * sy * sz,
          cx * sy * cz - sign * sx * cy * sz, cx * cy * sz + sign * sx * sy * cz};
}

PlcReplyDriver::PlcReplyDriver(DriverConfig config, DatagramOut& out, Sink<topic::Bodies> on_body,
                               Sink<topic::Mru> on_mru)
    : config_(std::move(config)), out_(out), on_body_(std::move(on_body)), on_mru_(std::move(on_mru)) {
  for (std::size_t ship = 0; ship < kShips.size(); ++ship) {
    topic::Bodies& body = bodies_[ship];
    body.device = config_.device;
    body.body = kShips[ship];
    body.tracked = true;
    body.residual_m = kNotTold;
    topic::Mru& unit = units_[ship];
    unit.device = config_.device + (ship == 0 ? "_mru1" : "_mru2");
    unit.omega_down_radps = unit.sensor_temperature_degc = kNotTold;
    unit.v_mru_mps.fill(kNotTold);
    unit.a_mru_mps2.fill(kNotTold);
    unit.a_heading_origin_mps2.fill(kNotTold);
  }
  health_.phase(LinkPhase::connecting);
}

void PlcReplyDriver::step(LabTime now) {
  if (!t_started_) t_started_ = now;
  if (now >= next_request_) ask(now);
  if (quiet(health_.t_received().value_or(*t_started_), now)) {
    health_.phase(health_.received() > 0 ? LinkPhase::down : LinkPhase::connecting);
  }
  health_.advice(advice(now));
}

void PlcReplyDriver::ask(LabTime now) {
  const Nanoseconds period = from_seconds(config_.period_s);
  const bool late = next_request_ == LabTime::min() || now - next_request_ >= period;
  next_request_ = (late ? now : next_request_) + period;
  if (const Status left = out_.send(config_.plc, kRequest); !left) {
    health_.rejected(left.fault());
    return;
  }
  ++sent_;
  if (health_.received() > 0) ++owed_;
}

void PlcReplyDriver::on_datagram(Bytes datagram, Endpoint from, LabTime t_received) {
  const Endpoint& expected = config_.plc;
  if (from.address != expected.address || (expected.port != 0 && from.port != expected.port)) {
    health_.rejected({Reason::foreign, "a datagram from somebody who is not the PLC: who sends it?"});
    return;
  }
  const Result<Reply> reply = decode_reply(datagram);
  if (!reply) return refuse(reply.fault(), t_received);
  count_reply();
  if (last_ && *reply == *last_) return;
  if (const Status newer = judge_time(*reply); !newer) return refuse(newer.fault(), t_received);
  health_.accepted(t_received - from_seconds(config_.latency_s), t_received);
  health_.phase(LinkPhase::up);
  for (std::size_t ship = 0; ship < kShips.size(); ++ship) {
    tell_platform(ship, reply->platforms[ship], t_received);
    tell_unit(ship, reply->mrus[ship], t_received);
  }
  last_ = *reply;
}

void PlcReplyDriver::refuse(Fault fault, LabTime t_received) noexcept {
  health_.rejected(fault);
  t_refused_ = t_received;
}

void PlcReplyDriver::count_reply() noexcept {
  if (owed_ > 0) --owed_;
  if (owed_ <= kUnderWay) return;
  health_.lost(owed_ - kUnderWay);
  owed_ = kUnderWay;
}

Status PlcReplyDriver::judge_time(const Reply& reply) noexcept {
  if (!last_ || reply.t_s >= last_->t_s) return Done{};
  if (last_->t_s - reply.t_s <= config_.restart_gap_s)
    return Fault{Reason::out_of_order, "the PLC's time is older than in the reply before"};
  health_.reconnected();
  return Done{};
}

void PlcReplyDriver::tell_platform(std::size_t ship, const PlatformFeedback& platform, LabTime t_received) {
  topic::Bodies& body = bodies_[ship];
  ++body.sequence_number;
  ++body.frame_number;
  body.t_measured_ns = to_ns(t_received - from_seconds(config_.latency_s));
  body.t_received_ns = to_ns(t_received);
  body.p_camera_body_m = lengths(platform.eta);
  body.q_camera_body = quaternion(platform.eta[3], platform.eta[4], platform.eta[5], config_.euler_order);
  if (on_body_) on_body_(body);
}

void PlcReplyDriver::tell_unit(std::size_t ship, const MruFeedback& unit, LabTime t_received) {
  if (unit == (last_ ? last_->mrus[ship] : MruFeedback{})) return;
  t_unit_[ship] = t_received;
  topic::Mru& sample = units_[ship];
  ++sample.sequence_number;
  sample.t_measured_ns = to_ns(t_received - from_seconds(config_.mru_latency_s));
  sample.t_received_ns = to_ns(t_received);
  sample.p_heading_origin_m = lengths(unit.eta);
  sample.euler_heading_mru_rad = angles(unit.eta);
  sample.v_heading_origin_mps = lengths(unit.v);
  sample.omega_mru_radps = angles(unit.v);
  if (on_mru_) on_mru_(sample);
}

bool PlcReplyDriver::quiet(LabTime since, LabTime now) const noexcept {
  return now - since > from_seconds(config_.silent_after_s);
}

std::string_view PlcReplyDriver::advice(LabTime now) const noexcept {
  if (quiet(health_.t_received().value_or(*t_started_), now)) {
    if (t_refused_ && !quiet(*t_refused_, now)) {
      return "No good reply from the PLC: see the counted reasons; another version of its program runs "
             "there.";
    }
    return last_ ? "The PLC has fallen silent, or repeats one reply: check its program, the cable and the "
                   "network."
                 : "Nothing has come from the PLC yet: it answers to one fixed address and port alone, which "
                   "no other remote client may have.";
  }
  if (!last_) return {};
  // A unit that was never heard has been quiet since the beginning.
  if (quiet(std::max(t_unit_[0], *t_started_), now))
    return "The PLC repeats the values of mru1 to the last bit: it does not hear that unit.";
  if (quiet(std::max(t_unit_[1], *t_started_), now))
    return "The PLC repeats the values of mru2 to the last bit: it does not hear that unit.";
  return {};
}

}  // namespace motionlab::plc_reply
