#include "simulators/qualisys/qualisys_device.hpp"

#include <algorithm>
#include <utility>

namespace motionlab::qualisys {

namespace {

constexpr Nanoseconds kGoodbyeTime = 100ms;
constexpr double kDefaultLateness_s = 0.1;
constexpr std::array<std::string_view, 11> kSimpleFaults = {
    "silent",  "loss",     "late",     "stop_measurement", "restart_timestamp", "stuck_frame_number",
    "foreign", "truncate", "oversize", "close_mid_frame",  "body_list_change"};
constexpr std::string_view kOcclude = "occlude";
constexpr std::string_view kForeignDatagram = "$GPGGA,this,is,another,protocol*00\r\n";
const BodyDefinition kIntruder{"intruder", true};

}  // namespace

QualisysDevice::QualisysDevice(DeviceConfig config, ServerOut& server, DatagramOut& datagrams)
    : config_(std::move(config)),
      server_(server),
      datagrams_(datagrams),
      jitter_(config_.seed, "qualisys/jitter"),
      loss_(config_.seed, "qualisys/loss"),
      list_(config_.bodies) {}

// Sessions
// -----------------------------------------------------------------------------------------------------

void QualisysDevice::on_accepted(SessionId session, Endpoint from, LabTime) {
  if (sessions_.size() >= config_.max_clients) {
    refuse(session, kTooManyClients);
    goodbyes_.push_back({session, std::nullopt});
    return;
  }
  sessions_[session].peer = from;
  reply(session, kWelcome);
}

void QualisysDevice::on_bytes(SessionId session, Bytes bytes, LabTime) {
  const auto found = sessions_.find(session);
  if (found == sessions_.end()) return;
  PacketSplitter& commands = found->second.commands;
  commands.push(bytes);
  while (const auto packet = commands.next()) {
    if (!*packet) {
      server_.close(session);
      on_closed(session, {});
      return;
    }
    if ((*packet)->type == PacketType::command)
      on_command(session, found->second, packet_text((*packet)->payload));
    else
      refuse(session, "Parse error");
  }
}

void QualisysDevice::on_closed(SessionId session, LabTime) {
  sessions_.erase(session);
  std::erase_if(goodbyes_, [&](const Goodbye& goodbye) { return goodbye.session == session; });
  if (master_ == session) master_.reset();
}

// Frames
// -------------------------------------------------------------------------------------------------------

void QualisysDevice::capture(const CameraFrame& seen, LabTime t_exposure) {
  if (!measuring()) return;
  if (!t_start_) t_start_ = t_exposure;
  ++frame_number_;
  const auto loss = fault("loss");
  const double probability = loss && *loss > 0.0 ? *loss : 1.0;
  if (loss && loss_.chance(probability)) return;

  ++frames_;
  Pending& pending = pending_.emplace_back();
  DataFrame& frame = pending.frame;
  frame.timestamp_us = static_cast<std::uint64_t>(std::max(t_exposure - *t_start_ + clock_jump_, 0ns) / 1us);
  frame.frame_number = fault("stuck_frame_number") ? 1 : frame_number_;
  frame.has_bodies = true;
  frame.drop_rate = seen.drop_rate;
  frame.out_of_sync_rate = seen.out_of_sync_rate;
  frame.body_count = std::min(list_.size(), kMaxBodies);
  for (std::size_t i = 0; i < frame.body_count; ++i) {
    const auto body = std::find_if(seen.bodies.begin(), seen.bodies.end(),
                                   [&](const MeasuredBody& b) { return same_name(b.name, list_[i].name); });
    if (body == seen.bodies.end() || !body->tracked || !list_[i].enabled || occluded(list_[i].name)) continue;
    frame.body[i] = {true, body->p_camera_body_m, body->q_camera_body, body->residual_m};
  }
  if (config_.camera_time)
    frame.timecode =
        CameraTime{t_exposure.time_since_epoch() + clock_jump_ + from_seconds(config_.camera_time_offset_s)};

  double delay_s = config_.latency_s;
  if (config_.jitter_s > 0.0) delay_s += jitter_.uniform(0.0, config_.jitter_s);
  if (const auto late = fault("late")) delay_s += *late > 0.0 ? *late : kDefaultLateness_s;
  t_last_due_ = pending.t_due = std::max(t_exposure + from_seconds(delay_s), t_last_due_);
}

void QualisysDevice::step(LabTime now) {
  for (Goodbye& goodbye : goodbyes_) {
    if (!goodbye.t_close) goodbye.t_close = now + kGoodbyeTime;
    if (now >= *goodbye.t_close) server_.close(goodbye.session);
  }
  std::erase_if(goodbyes_, [&](const Goodbye& goodbye) { return now >= *goodbye.t_close; });
  while (!pending_.empty() && pending_.front().t_due <= now) {
    deliver(pending_.front().frame);
    pending_.pop_front();
  }
}

void QualisysDevice::deliver(const DataFrame& frame) {
  ++delivered_;
  for (auto& [id, session] : sessions_) {
    if (session.current_frame) {
      const auto packet = encode_data(frame, *session.current_frame, packet_);
      if (packet) send(id, *packet);
      session.current_frame.reset();
    }
    if (!session.stream || !takes(*session.stream, delivered_)) continue;
    const auto packet = encode_data(frame, session.stream->components, packet_);
    if (!packet) continue;
    if (session.stream->udp)
      send_datagram(*session.stream->udp, *packet);
    else
      send(id, *packet);
  }
}

/// Whether the stream gets this frame: every n-th, or as many of them as its frequency asks for.
bool QualisysDevice::takes(Stream& stream, std::uint64_t frame_index) {
  if (stream.divisor != 0) return frame_index % stream.divisor == 0;
  stream.credit += stream.share;
  if (stream.credit < 1.0) return false;
  stream.credit -= 1.0;
  return true;
}

// Sending
// ------------------------------------------------------------------------------------------------------

void QualisysDevice::reply(SessionId id, std::string_view text) {
  send(id, encode_text(PacketType::command, text));
}

void QualisysDevice::refuse(SessionId id, std::string_view text) {
  send(id, encode_text(PacketType::error, text));
}

/// Header and payload leave together: the vendor's client takes a split header for the end of the session.
void QualisysDevice::send(SessionId id, Bytes packet) {
  if (fault("silent")) return;
  if (!server_.send(id, packet)) ++send_failures_;
}

void QualisysDevice::send_all(Bytes packet) {
  for (const auto& [id, session] : sessions_) send(id, packet);
}

/// @param packet  inside `packet_`, which has room behind it
void QualisysDevice::send_datagram(Endpoint to, Bytes packet) {
  if (fault("silent")) return;
  std::size_t size = packet.size();
  if (fault("truncate")) --size;
  if (fault("oversize")) size = std::min(size + 1, packet_.size());
  if (!datagrams_.send(to, Bytes{packet_}.first(size))) ++send_failures_;
  if (fault("foreign") && !datagrams_.send(to, as_bytes(kForeignDatagram))) ++send_failures_;
}

// Faults
// -------------------------------------------------------------------------------------------------------

Status QualisysDevice::set_fault(std::string_view name, bool active, double value) {
  if (name == kOcclude || name.starts_with("occlude:")) {
    const std::string_view body = name == kOcclude ? "" : name.substr(kOcclude.size() + 1);
    const bool known = std::any_of(config_.bodies.begin(), config_.bodies.end(),
                                   [&](const BodyDefinition& b) { return same_name(b.name, body); });
    if (name != kOcclude && !known)
      return Fault{Reason::refused, "occlude:<body> names a body that is not there"};
    std::erase_if(occluded_, [&](const std::string& o) { return same_name(o, body); });
    if (active) occluded_.emplace(body);
    return Done{};
  }
  if (std::find(kSimpleFaults.begin(), kSimpleFaults.end(), name) == kSimpleFaults.end())
    return Fault{Reason::refused, kFaults};

  const bool was_active = fault(name).has_value();
  if (active)
    faults_.insert_or_assign(std::string{name}, value);
  else if (was_active)
    faults_.erase(faults_.find(name));
  if (active == was_active) return Done{};

  if (name == "stop_measurement") active ? stop_measurement() : start_measurement();
  if (name == "body_list_change") set_body_list(active, value == 0.0);
  if (name == "restart_timestamp" && active) restart_time();
  if (name == "close_mid_frame" && active) close_mid_frame();
  return Done{};
}

std::optional<double> QualisysDevice::fault(std::string_view name) const {
  const auto found = faults_.find(name);
  return found == faults_.end() ? std::nullopt : std::optional{found->second};
}

/// An empty name stands for all.
bool QualisysDevice::occluded(const std::string& body) const {
  return std::any_of(occluded_.begin(), occluded_.end(),
                     [&](const std::string& o) { return o.empty() || same_name(o, body); });
}

void QualisysDevice::restart_time() {
  t_start_.reset();
  frame_number_ = 0;
}

void QualisysDevice::start_measurement() {
  restart_time();
  state_ = Event::capture_started;
  send_all(encode_event(state_));
}

void QualisysDevice::stop_measurement() {
  pending_.clear();
  state_ = Event::capture_stopped;
  send_all(encode_event(state_));
  for (const auto& [id, session] : sessions_)
    if (session.stream) send(id, encode_no_more_data());
}

void QualisysDevice::close_mid_frame() {
  const ByteBuffer packet =
      encode_text(PacketType::xml, write_parameters_xml({.bodies = true, .body_list = list_}));
  send_all(Bytes{packet}.first(packet.size() / 2));
  for (const auto& [id, session] : sessions_) goodbyes_.push_back({id, std::nullopt});
  sessions_.clear();
  master_.reset();
}

void QualisysDevice::set_body_list(bool changed, bool announced) {
  list_ = config_.bodies;
  if (changed) list_.insert(list_.begin(), kIntruder);
  if (announced) send_all(encode_event(Event::camera_settings_changed));
}

}  // namespace motionlab::qualisys
