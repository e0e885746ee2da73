#include "simulators/qualisys/qualisys_device.hpp"

#include <algorithm>
#include <utility>

#include "drivers/qualisys/qualisys_wire_discovery.hpp"
#include "drivers/qualisys/qualisys_wire_text.hpp"

namespace motionlab::qualisys {

namespace {

constexpr std::size_t kCommandLimit = 65536;
constexpr std::size_t kAnswersMax = 256;
constexpr std::size_t kEmptyFrameSize = 24;  ///< of a data packet without components
constexpr Nanoseconds kGoodbyeTime = 100ms;
constexpr int kFirstVersionWithSubFrames = 27;

/// Keeps what clients see from going back in time when a delay ends.
LabTime no_earlier(LabTime t, LabTime than) {
  return std::max(t, than);
}

}  // namespace

QualisysDevice::QualisysDevice(DeviceConfig config, ServerOut& server, DatagramOut& datagrams)
    : config_(std::move(config)),
      server_(server),
      datagrams_(datagrams),
      jitter_(config_.seed, "qualisys/jitter"),
      garbage_(config_.seed, "qualisys/garbage") {
  boot();
}

// Sessions
// -----------------------------------------------------------------------------------------------------

ServerEvents& QualisysDevice::serve_big_endian(ServerOut& server) {
  big_endian_server_ = &server;
  return big_endian_port_;
}

void QualisysDevice::BigEndianPort::on_accepted(SessionId session, Endpoint from, LabTime t) {
  device_.accept({std::endian::big, session}, from, t);
}
void QualisysDevice::BigEndianPort::on_bytes(SessionId session, Bytes bytes, LabTime t_received) {
  device_.receive({std::endian::big, session}, bytes, t_received);
}
void QualisysDevice::BigEndianPort::on_closed(SessionId session, LabTime) {
  device_.forget({std::endian::big, session});
}
void QualisysDevice::on_accepted(SessionId session, Endpoint from, LabTime t) {
  accept({std::endian::little, session}, from, t);
}
void QualisysDevice::on_bytes(SessionId session, Bytes bytes, LabTime t_received) {
  receive({std::endian::little, session}, bytes, t_received);
}
void QualisysDevice::on_closed(SessionId session, LabTime) {
  forget({std::endian::little, session});
}

void QualisysDevice::accept(SessionKey key, Endpoint from, LabTime t) {
  now_ = t;
  if (faults_.is_on("restart")) return goodbyes_.push_back({key, t});
  Session session{key, from, PacketSplitter{kCommandLimit, key.order}, 1, {}, {}, {}};
  if (sessions_.size() >= config_.max_clients) {
    refuse(session, kTooManyClients);
    goodbyes_.push_back({key, std::nullopt});
    return;
  }
  reply(sessions_.emplace(key, std::move(session)).first->second, kWelcome);
}

void QualisysDevice::receive(SessionKey key, Bytes bytes, LabTime t) {
  now_ = t;
  const auto found = sessions_.find(key);
  if (found == sessions_.end() || common_.off() || faults_.is_on("half_open")) return;
  PacketSplitter& commands = found->second.commands;
  commands.push(bytes);
  while (const auto packet = commands.next()) {
    if (!*packet) return close(key);
    on_packet(found->second, **packet);
    if (!sessions_.contains(key)) return;
  }
}

void QualisysDevice::forget(SessionKey key) {
  sessions_.erase(key);
  std::erase_if(goodbyes_, [&](const Goodbye& goodbye) { return goodbye.session == key; });
  if (master_ == key) master_.reset();
}

void QualisysDevice::close(SessionKey key) {
  (key.order == std::endian::little ? server_ : *big_endian_server_).close(key.id);
  forget(key);
}

void QualisysDevice::on_discovery(Bytes datagram, Endpoint from, LabTime t) {
  now_ = t;
  const auto port = decode_discovery(datagram);
  if (!port || common_.off() || faults_.is_on("restart")) return;
  const std::string info = config_.host + ", QTM " + config_.qtm_version + ", 17 cameras";
  ByteBuffer answer = encode_discovery_answer({info, config_.base_port});
  send_datagram({from.address, *port}, answer);
}

// Frames
// -------------------------------------------------------------------------------------------------------

bool QualisysDevice::measuring() const noexcept {
  return state_ == Event::connected || state_ == Event::capture_started ||
         state_ == Event::rt_from_file_started || state_ == Event::waiting_for_trigger;
}

void QualisysDevice::capture(const CameraFrame& seen, LabTime t_exposure) {
  if (!measuring() || common_.off() || faults_.is_on("restart")) return;
  ++exposures_;
  if (exposures_ % static_cast<std::uint64_t>(std::max(common_.slow_by(), 1.0)) != 0) return;
  if (!t_start_) t_start_ = t_exposure;
  ++frame_number_;
  const double skip = faults_.value("skip_frames").value_or(1.0);
  if (frame_number_ % static_cast<std::uint32_t>(std::max(skip, 1.0)) != 0) return;
  if (!common_.stuck()) seen_ = seen;

  ++frames_;
  Pending& pending = pending_.emplace_back();
  pending.frame = frame_of(seen_, list_, config_.labels, faults_, common_.wrong_by());
  pending.frame.timestamp_us =
      static_cast<std::uint64_t>(std::max(t_exposure - *t_start_ + clock_jump_, 0ns) / 1us);
  pending.frame.frame_number = faults_.is_on("stuck_frame_number") ? 1 : frame_number_;
  pending.frame.timecode =
      timecode_of(config_.timecode, t_exposure + clock_jump_, config_.camera_time_offset_s);

  double delay_s = config_.latency_s;
  if (config_.jitter_s > 0.0) delay_s += jitter_.uniform(0.0, config_.jitter_s);
  pending.t_due = no_earlier(t_exposure + from_seconds(delay_s) + common_.delay(), t_last_due_);
  t_last_due_ = pending.t_due;
}

void QualisysDevice::step(LabTime now) {
  now_ = now;
  const auto due = [&](Goodbye& goodbye) {
    if (!goodbye.t_close) goodbye.t_close = now + kGoodbyeTime;
    return now >= *goodbye.t_close;
  };
  std::vector<SessionKey> leaving;
  for (Goodbye& goodbye : goodbyes_)
    if (due(goodbye)) leaving.push_back(goodbye.session);
  for (auto& [key, session] : sessions_) {
    flush(session);
    if (session.answers.size() > kAnswersMax) leaving.push_back(key);
  }
  for (const SessionKey key : leaving) close(key);
  while (!pending_.empty() && pending_.front().t_due <= now) {
    deliver(pending_.front().frame);
    pending_.pop_front();
  }
}

void QualisysDevice::deliver(const DataFrame& frame) {
  ++delivered_;
  for (auto& [key, session] : sessions_) {
    if (const auto asked = std::exchange(session.current_frame, std::nullopt))
      deliver(session, frame, *asked, std::nullopt);
    if (session.stream && takes(*session.stream, delivered_))
      deliver(session, frame, session.stream->components, session.stream->udp);
  }
}

void QualisysDevice::deliver(Session& session, const DataFrame& frame, const Components& components,
                             std::optional<Endpoint> udp) {
  if (session.version_minor < kFirstVersionWithSubFrames && frame.timecode) {
    if (const auto* smpte = std::get_if<SmpteTime>(&*frame.timecode); smpte && smpte->sub_frame != 0) {
      DataFrame without = frame;
      std::get<SmpteTime>(*without.timecode).sub_frame = 0;
      return deliver(session, without, components, udp);
    }
  }
  const bool splits = udp && faults_.is_on("split_frame");
  const auto send_part = [&](const Components& part) {
    // One byte is kept free for a fault.
    const auto packet =
        encode_data(frame, part, MutableBytes{packet_}.first(packet_.size() - 1), session.key.order);
    if (!packet || (splits && packet->size() == kEmptyFrameSize)) return;
    if (udp)
      send_datagram(*udp, MutableBytes{packet_}.first(packet->size() + (faults_.is_on("oversize") ? 1 : 0)));
    else
      send_data(session, *packet);
  };
  if (!splits) return send_part(components);
  for (const ComponentWord& entry : kComponentWords)
    if (components.has(entry.component)) send_part({entry.component});
}

/// Whether the stream gets this frame: every n-th, or as many of them as its frequency asks for.
bool QualisysDevice::takes(Stream& stream, std::uint64_t frame_index) {
  if (!stream.share) return frame_index % stream.divisor == 0;
  stream.credit += *stream.share;
  if (stream.credit < 1.0) return false;
  stream.credit -= 1.0;
  return true;
}

// Sending
// ------------------------------------------------------------------------------------------------------

void QualisysDevice::reply(Session& session, std::string_view text) {
  answer(session, encode_text(PacketType::command, text, session.key.order));
}

void QualisysDevice::refuse(Session& session, std::string_view text) {
  answer(session, encode_text(PacketType::error, text, session.key.order));
}

/// Answers wait for a client that does not read; they are never dropped and never overtake each other.
void QualisysDevice::answer(Session& session, ByteBuffer packet) {
  session.answers.push_back({std::move(packet), now_ + common_.delay()});
  flush(session);
}

void QualisysDevice::flush(Session& session) {
  while (!session.answers.empty() && session.answers.front().t_due <= now_) {
    if (!send(session, session.answers.front().packet)) return;
    session.answers.pop_front();
  }
}

void QualisysDevice::tell_all(Event event) {
  for (auto& [key, session] : sessions_) answer(session, encode_event(event, key.order));
}

void QualisysDevice::send_data(Session& session, Bytes packet) {
  flush(session);
  const bool behind = !session.answers.empty() && session.answers.front().t_due <= now_;
  if (behind || !send(session, packet)) ++send_failures_;
}

/// Header and payload leave together: the vendor's client takes a split header for the end of the session.
/// @returns false when the client has not taken what was sent before
bool QualisysDevice::send(const Session& session, Bytes packet) {
  constexpr std::size_t kInsideHeader = 5;
  if (!common_.speaks(now_) || faults_.is_on("silent") || faults_.is_on("half_open")) return true;
  ServerOut& server = session.key.order == std::endian::little ? server_ : *big_endian_server_;
  const ByteBuffer bytes = disturbed(packet);
  if (!faults_.is_on("split_header")) return server.send(session.key.id, bytes).ok();
  return server.send(session.key.id, Bytes{bytes}.first(kInsideHeader)).ok() &&
         server.send(session.key.id, Bytes{bytes}.subspan(kInsideHeader)).ok();
}

void QualisysDevice::send_datagram(Endpoint to, MutableBytes packet) {
  if (!common_.speaks(now_) || faults_.is_on("silent")) return;
  if (!datagrams_.send(to, disturbed(packet))) ++send_failures_;
}

/// The bytes themselves, or garbage of the same length.
ByteBuffer QualisysDevice::disturbed(Bytes packet) {
  ByteBuffer bytes{packet.begin(), packet.end()};
  if (common_.garbage())
    for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(garbage_.bits());
  return bytes;
}

// The measurement
// ----------------------------------------------------------------------------------------------

void QualisysDevice::restart_time() {
  t_start_.reset();
  frame_number_ = 0;
}

/// Frames come from now on.
void QualisysDevice::begin(Event event) {
  restart_time();
  state_ = event;
  tell_all(event);
}

/// No frames come any more.
void QualisysDevice::end(Event event) {
  pending_.clear();
  state_ = event;
  tell_all(event);
  for (auto& [key, session] : sessions_)
    if (session.stream) answer(session, encode_no_more_data(key.order));
}

/// As after the start of the program: nobody is connected, the project's list of bodies is back.
void QualisysDevice::boot() {
  while (!sessions_.empty()) close(sessions_.begin()->first);
  master_.reset();
  pending_.clear();
  list_ = config_.bodies;
  restart_time();
  state_ = config_.measures_at_start ? Event::capture_started : Event::connection_closed;
}

/// Closes every connection once what was said has arrived.
void QualisysDevice::say_goodbye() {
  for (const auto& [key, session] : sessions_) goodbyes_.push_back({key, std::nullopt});
  sessions_.clear();
  master_.reset();
}

void QualisysDevice::close_mid_frame() {
  for (const auto& [key, session] : sessions_) {
    const ByteBuffer packet =
        encode_text(PacketType::xml, write_parameters_xml({.bodies = true, .body_list = list_}), key.order);
    (void)send(session, Bytes{packet}.first(packet.size() / 2));
  }
  say_goodbye();
}

void QualisysDevice::set_body_list(std::vector<BodyDefinition> list, bool announced) {
  list_ = std::move(list);
  if (announced) tell_all(Event::camera_settings_changed);
}

// Faults
// -------------------------------------------------------------------------------------------------------

std::string QualisysDevice::fault_names() const {
  std::string names{faults::CommonFaults::kNames};
  for (const std::string_view name : DeviceFaults::names()) names.append(" ").append(name);
  for (const BodyDefinition& body : config_.bodies) names.append(" occlude:").append(body.name);
  return names;
}

Status QualisysDevice::set_fault(std::string_view name, bool active, double value) {
  const bool was_off = common_.off();
  if (common_.set(name, active, value)) {
    if (was_off && !common_.off()) boot();
    return Done{};
  }
  if (const auto body = after("occlude:", name)) {
    const bool known = std::any_of(config_.bodies.begin(), config_.bodies.end(),
                                   [&](const BodyDefinition& b) { return same_name(b.name, *body); });
    if (!known) return Fault{Reason::refused, "occlude:<body> names a body that is not there"};
    faults_.set_occluded(*body, active);
    return Done{};
  }
  if (!DeviceFaults::knows(name)) return Fault{Reason::refused, DeviceFaults::kNames};
  const double value_before = faults_.value(name).value_or(0.0);
  if (!faults_.set(name, active, value)) return Done{};
  active ? begin_fault(name, value) : end_fault(name, value_before);
  return Done{};
}

void QualisysDevice::begin_fault(std::string_view name, double value) {
  if (name == "stop_measurement") end(Event::capture_stopped);
  if (name == "calibrate") end(Event::calibration_started);
  if (name == "restart") {
    tell_all(Event::shutting_down);
    say_goodbye();
  }
  if (name == "restart_timestamp") restart_time();
  if (name == "close_mid_frame") close_mid_frame();
  if (name == "old_version") say_goodbye();
  if (name == "body_list_change") {
    std::vector<BodyDefinition> list = config_.bodies;
    list.insert(list.begin(), {"intruder", true});
    set_body_list(std::move(list), value == 0.0);
  }
}

void QualisysDevice::end_fault(std::string_view name, double value) {
  if (name == "stop_measurement") begin(Event::capture_started);
  if (name == "calibrate") {
    tell_all(Event::calibration_stopped);
    begin(Event::connected);
  }
  if (name == "restart") boot();
  if (name == "body_list_change") set_body_list(config_.bodies, value == 0.0);
}

}  // namespace motionlab::qualisys
