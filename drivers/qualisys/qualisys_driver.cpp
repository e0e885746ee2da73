#include "drivers/qualisys/qualisys_driver.hpp"

#include <algorithm>
#include <utility>

#include "drivers/qualisys/qualisys_driver_faults.hpp"
#include "drivers/qualisys/qualisys_wire_text.hpp"

namespace motionlab::qualisys {

namespace {

using State = QualisysDriver::State;

/// Newer ones have nothing that we use; older ones describe bodies otherwise.
constexpr int kNewestVersionMinor = 25;
constexpr int kOldestVersionMinor = 21;

constexpr std::string_view kIdleAdvice =
    "QTM does not measure: start a preview, a capture or a real-time playback of a file";
constexpr std::string_view kNoListAdvice =
    "QTM gives no list of rigid bodies: check that 6DOF tracking is switched on in the project";
constexpr std::string_view kSilentAdvice =
    "QTM measures but no frames arrive: check that the host's firewall admits the UDP port of the stream";
constexpr std::string_view kAmbiguousAdvice =
    "more than one pair of markers has the hook's spacing: cover the others, or label them in QTM";
constexpr Fault kNotQtm{
    Reason::bad_header,
    "the greeting is not QTM's: check address, port and byte order (22223 is little-endian)"};

/// Whether QTM measures, of the events that tell.
std::optional<bool> measures(Event event) noexcept {
  switch (event) {
    case Event::connected:
    case Event::capture_started:
    case Event::rt_from_file_started:
    case Event::waiting_for_trigger:
      return true;
    case Event::connection_closed:
    case Event::capture_stopped:
    case Event::calibration_started:
    case Event::calibration_stopped:
    case Event::rt_from_file_stopped:
      return false;
    default:
      return std::nullopt;
  }
}

Fault no_answer(State state) noexcept {
  switch (state) {
    case State::connecting:
      return {Reason::transport, "QTM cannot be reached: check that it runs, its address, and the network"};
    case State::welcome:
      return {Reason::transport,
              "no greeting from QTM: check address and port (22223 is little-endian, 22224 big-endian)"};
    case State::bodies:
      return {Reason::transport, "QTM does not answer GetParameters: connecting again"};
    default:
      return {Reason::transport, "QTM does not answer: connecting again"};
  }
}

std::string make_stream_command(const DriverConfig& config) {
  std::string text = "StreamFrames AllFrames ";
  if (config.udp_port != 0) text += "UDP:" + std::to_string(config.udp_port) + " ";
  text += "6DRes ";
  if (!config.hook.name.empty()) text += "3DNoLabels ";
  return text + "Timecode";
}

}  // namespace

QualisysDriver::QualisysDriver(DriverConfig config, StreamOut& control, Sink<topic::Bodies> sink)
    : config_(std::move(config)),
      control_(control),
      sink_(std::move(sink)),
      splitter_(kStreamPacketLimit, config_.byte_order),
      clock_({.latency = from_seconds(config_.latency_s)}),
      stream_command_(make_stream_command(config_)),
      version_minor_(kNewestVersionMinor),
      backoff_s_(config_.backoff_min_s),
      pair_(config_.hook) {
  hook_.name = config_.hook.name;
  for (const std::string& name : config_.bodies) {
    Wanted body;
    body.name = name;
    body.missing_advice = "QTM knows no body '" + name + "': name it so in QTM, or correct the configuration";
    body.disabled_advice = "body '" + name + "' is disabled in QTM: enable it there";
    wanted_.push_back(std::move(body));
  }
}

// The connection
// -----------------------------------------------------------------------------------------------

void QualisysDriver::on_open(LabTime t) {
  if (state_ != State::connecting) return;
  if (was_connected_) health_.reconnected();
  was_connected_ = true;
  t_bytes_ = t;
  enter(State::welcome, t);
}

void QualisysDriver::on_closed(std::string_view, LabTime t) {
  if (state_ == State::down) return;
  fail(
      state_ == State::connecting ? no_answer(state_) : Fault{Reason::transport, "QTM closed the connection"},
      t);
}

void QualisysDriver::on_bytes(Bytes bytes, LabTime t_received) {
  if (state_ == State::down || state_ == State::connecting) return;
  t_bytes_ = t_received;
  splitter_.push(bytes);
  while (const auto packet = splitter_.next()) {
    if (!*packet) return fail(state_ == State::welcome ? kNotQtm : packet->fault(), t_received);
    on_packet(**packet, t_received);
    if (state_ == State::down) return;
  }
}

void QualisysDriver::connect(LabTime now) {
  splitter_.reset();
  event_.reset();
  measuring_ = false;
  probing_ = false;
  restream_ = false;
  list_outdated_ = false;
  list_refused_ = false;
  wrong_count_ = false;
  silent_ = false;
  version_minor_ = kNewestVersionMinor;
  orientation_.reset();
  forget_time();
  health_.phase(LinkPhase::connecting);
  enter(State::connecting, now);
  control_.open();
}

/// Counts the fault, makes its text the advice, lets go of the bodies and waits for the next attempt.
void QualisysDriver::fail(Fault fault, LabTime now) {
  health_.rejected(fault);
  health_.phase(LinkPhase::down);
  health_.advice(fault.text);
  control_.close();
  lose_all(now);
  enter(State::down, now);
  t_attempt_ = now + from_seconds(backoff_s_);
  backoff_s_ = std::min(2.0 * backoff_s_, config_.backoff_max_s);
}

void QualisysDriver::enter(State state, LabTime now) noexcept {
  state_ = state;
  t_state_ = now;
}

void QualisysDriver::command(std::string_view text, LabTime now) {
  const Status sent = control_.send(encode_text(PacketType::command, text, config_.byte_order));
  if (!sent) fail(sent.fault(), now);
}

// Time
// ---------------------------------------------------------------------------------------------------------

void QualisysDriver::step(LabTime now) {
  if (state_ == State::down) {
    if (!t_attempt_ || now >= *t_attempt_) connect(now);
    return;
  }
  const Nanoseconds reply_timeout = from_seconds(config_.reply_timeout_s);
  const bool waits_for_answer = state_ != State::streaming && state_ != State::idle;
  if (waits_for_answer && now - t_state_ > reply_timeout) return fail(no_answer(state_), now);
  if (probing_ && now - t_probe_ > reply_timeout)
    return fail({Reason::transport, "QTM does not answer GetState: connecting again"}, now);
  if (splitter_.in_packet() && now - t_bytes_ > reply_timeout)
    return fail({Reason::transport, "QTM began a packet and did not end it: connecting again"}, now);

  if (showing_ && now - t_frame_ > from_seconds(config_.stale_after_periods * config_.frame_period_s))
    lose_all(now);
  if (showing_ && orientation_.due(now)) {
    orientation_.asked(now);
    command("GetCurrentFrame 6D 6DEuler", now);
    if (state_ == State::down) return;
  }
  const Nanoseconds pause = from_seconds(config_.probe_after_s);
  const bool no_frames = state_ == State::idle || (state_ == State::streaming && now - t_frame_ >= pause);
  if (no_frames && !probing_ && now - t_probe_ >= pause) probe(now);
}

/// Asks for the state: the only sign of life that the protocol has.
void QualisysDriver::probe(LabTime now) {
  probing_ = true;
  t_probe_ = now;
  command("GetState", now);
}

// The conversation
// ---------------------------------------------------------------------------------------------

void QualisysDriver::on_packet(const Packet& packet, LabTime t) {
  switch (packet.type) {
    case PacketType::error:
    case PacketType::command:
      return on_text(packet.type, packet_text(packet.payload), t);
    case PacketType::xml:
      return on_body_list(packet_text(packet.payload), t);
    case PacketType::no_more_data:
      return on_no_more_data(t);
    case PacketType::event:
      if (const auto event = decode_event(packet.payload))
        on_event(*event, t);
      else
        health_.rejected(event.fault());
      return;
    case PacketType::data:
      return config_.udp_port == 0 ? on_frame(packet.payload, t) : on_checked_frame(packet.payload);
    default:
      break;
  }
  health_.rejected({Reason::unexpected, "QTM sent a packet that was not asked for"});
}

void QualisysDriver::on_text(PacketType type, std::string_view text, LabTime t) {
  const bool error = type == PacketType::error;
  switch (state_) {
    case State::welcome:
      if (error) return fail({Reason::refused, "QTM refuses the connection: it has too many clients"}, t);
      if (!text.starts_with(kWelcome)) return fail(kNotQtm, t);
      return ask_version(t);
    case State::version:
      return on_version(type, text, t);
    case State::qtm_version:
      qtm_version_ = error ? std::string_view{} : text;  // only for people: its absence is no fault
      enter(State::get_state, t);
      return probe(t);
    case State::bodies:
      if (!error) break;
      health_.rejected({Reason::refused, kNoListAdvice});
      list_refused_ = true;
      lose_all(t);
      enter(State::idle, t);
      return advise();
    default:
      break;
  }
  if (error)
    health_.rejected({Reason::refused, "QTM refused a command: see its message window"});
  else
    health_.rejected({Reason::unexpected, "QTM answered what was not asked"});
}

void QualisysDriver::ask_version(LabTime now) {
  enter(State::version, now);
  command("Version 1." + std::to_string(version_minor_), now);
}

/// A refusal may come as an error or as an answer: the documentation does not say.
void QualisysDriver::on_version(PacketType type, std::string_view text, LabTime t) {
  if (type == PacketType::error || same_name(text, "Version NOT supported")) {
    if (version_minor_ == kOldestVersionMinor)
      return fail(
          {Reason::refused, "QTM speaks none of the protocols 1.25 to 1.21: update QTM (2021 or newer)"}, t);
    --version_minor_;
    return ask_version(t);
  }
  if (text != "Version set to 1." + std::to_string(version_minor_))
    return fail({Reason::refused, "QTM set another protocol version than asked for: connecting again"}, t);
  enter(State::qtm_version, t);
  command("QTMVersion", t);
}

void QualisysDriver::on_event(Event event, LabTime t) {
  if (event == Event::shutting_down) return fail({Reason::transport, "QTM was closed: start it again"}, t);
  if (event == Event::camera_settings_changed) {
    orientation_.reset();
    if (state_ == State::streaming) return read_bodies(false, t);
    list_outdated_ = state_ == State::bodies;
    return;
  }
  const auto measuring = measures(event);
  if (!measuring) return;
  // The answer to GetState looks like an event; one that tells nothing new is taken for the answer.
  const bool answer = probing_ && event_ == event;
  probing_ = false;
  event_ = event;
  measuring_ = *measuring;

  switch (state_) {
    case State::get_state:
      return read_bodies(true, t);
    case State::bodies:
      if (measuring_ && !answer) restream_ = list_outdated_ = true;
      return;
    case State::streaming:
      if (!measuring_) {
        lose_all(t);
        enter(State::idle, t);
        return advise();
      }
      if (!answer) return begin_measurement(t);
      silent_ = true;
      advise();
      return command(stream_command_, t);
    case State::idle:
      if (measuring_) begin_measurement(t);
      return;
    default:
      return;
  }
}

void QualisysDriver::on_no_more_data(LabTime t) {
  measuring_ = false;
  if (state_ != State::streaming) return;
  lose_all(t);
  enter(State::idle, t);
  advise();
}

/// The list may be another, time stamps and frame numbers may start again.
void QualisysDriver::begin_measurement(LabTime now) {
  lose_all(now);
  read_bodies(true, now);
}

/// Frames that come before the list is read are not told: their order of bodies is not known.
void QualisysDriver::read_bodies(bool restream, LabTime now) {
  restream_ = restream_ || restream;
  list_outdated_ = false;
  t_list_ = now;
  enter(State::bodies, now);
  command("GetParameters 6D", now);
}

void QualisysDriver::on_body_list(std::string_view xml, LabTime t) {
  if (state_ != State::bodies)
    return health_.rejected({Reason::unexpected, "QTM sent parameters that were not asked for"});
  auto list = parse_bodies_xml(xml);
  if (!list) return fail(list.fault(), t);
  if (list_outdated_) return read_bodies(restream_, t);

  if (*list != list_) lose_all(t);
  list_ = std::move(list).value();
  for (Wanted& body : wanted_) {
    const auto found = std::find_if(list_.begin(), list_.end(),
                                    [&](const BodyDefinition& b) { return same_name(b.name, body.name); });
    body.index.reset();
    if (found == list_.end()) continue;
    body.index = static_cast<std::size_t>(found - list_.begin());
    body.enabled = found->enabled;
  }
  list_refused_ = false;
  wrong_count_ = false;
  backoff_s_ = config_.backoff_min_s;
  health_.phase(LinkPhase::up);
  enter(measuring_ ? State::streaming : State::idle, t);
  advise();
  if (!measuring_) {
    lose_all(t);
    t_probe_ = t;
    return;
  }
  if (!std::exchange(restream_, false)) return;
  forget_time();
  t_frame_ = t;
  command(stream_command_, t);
}

void QualisysDriver::advise() noexcept {
  if (list_refused_) return health_.advice(kNoListAdvice);
  if (state_ == State::idle) return health_.advice(kIdleAdvice);
  if (wrong_count_) return health_.advice(kWrongCount.text);
  if (silent_) return health_.advice(kSilentAdvice);
  for (const Wanted& body : wanted_) {
    if (!body.index) return health_.advice(body.missing_advice);
    if (!body.enabled) return health_.advice(body.disabled_advice);
  }
  if (pair_.ambiguous()) return health_.advice(kAmbiguousAdvice);
  health_.advice(orientation_.advice());
}

}  // namespace motionlab::qualisys
