#include "drivers/qualisys/qualisys_driver.hpp"

#include <algorithm>
#include <utility>

namespace motionlab::qualisys {

namespace {

using State = QualisysDriver::State;

constexpr std::string_view kVersionCommand = "Version 1.25";
constexpr std::string_view kVersionAnswer = "Version set to 1.25";

/// A time stamp that goes back by less than this is a late datagram, by more it may be a new measurement.
constexpr std::uint64_t kRestart_us = 500'000;
/// A wrong number of bodies makes us read the list again, but not at the pace of the frames.
constexpr Nanoseconds kListPause = 1s;

constexpr std::string_view kIdleAdvice =
    "QTM does not measure: start a preview, a capture or a real-time playback of a file";
constexpr std::string_view kNoListAdvice =
    "QTM gives no list of rigid bodies: check that 6DOF tracking is switched on in the project";
constexpr std::string_view kSilentAdvice =
    "QTM measures but no frames arrive: check that the host's firewall admits the UDP port of the stream";
constexpr std::string_view kWrongCountAdvice =
    "frames hold another number of bodies than QTM's list: reading the list again";

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
              "no greeting from QTM: check that the port is the little-endian one (22223)"};
    case State::bodies:
      return {Reason::transport, "QTM does not answer GetParameters: connecting again"};
    default:
      return {Reason::transport, "QTM does not answer: connecting again"};
  }
}

std::string make_stream_command(std::uint16_t udp_port) {
  std::string text = "StreamFrames AllFrames ";
  if (udp_port != 0) text += "UDP:" + std::to_string(udp_port) + " ";
  return text + "6DRes Timecode";
}

}  // namespace

QualisysDriver::QualisysDriver(DriverConfig config, StreamOut& control, Sink<topic::Bodies> sink)
    : config_(std::move(config)),
      control_(control),
      sink_(std::move(sink)),
      clock_({.latency = from_seconds(config_.latency_s)}),
      stream_command_(make_stream_command(config_.udp_port)),
      backoff_s_(config_.backoff_min_s) {
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
    if (!*packet) return fail(packet->fault(), t_received);
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
  const Status sent = control_.send(encode_text(PacketType::command, text));
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
      if (config_.udp_port == 0) return on_frame(packet.payload, t);
      break;
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
      if (!text.starts_with(kWelcome))
        return fail({Reason::bad_header, "the greeting is not QTM's: check address and port (22223)"}, t);
      enter(State::version, t);
      return command(kVersionCommand, t);
    case State::version:
      if (error || text != kVersionAnswer)
        return fail({Reason::refused, "QTM does not speak protocol 1.25: update QTM"}, t);
      enter(State::qtm_version, t);
      return command("QTMVersion", t);
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

void QualisysDriver::on_event(Event event, LabTime t) {
  if (event == Event::shutting_down) return fail({Reason::transport, "QTM was closed: start it again"}, t);
  if (event == Event::camera_settings_changed) {
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

// Frames
// -------------------------------------------------------------------------------------------------------

void QualisysDriver::on_datagram(Bytes datagram, Endpoint from, LabTime t_received) {
  if (config_.server_address != 0 && from.address != config_.server_address)
    return health_.rejected(
        {Reason::foreign, "datagram on the stream's port from another address than QTM's"});
  const auto packet = decode_datagram(datagram);
  if (!packet) return health_.rejected(packet.fault());
  if (packet->type == PacketType::data) return on_frame(packet->payload, t_received);
  if (packet->type == PacketType::no_more_data) return on_no_more_data(t_received);
  health_.rejected({Reason::bad_header, "datagram on the stream's port is not a data packet"});
}

void QualisysDriver::on_frame(Bytes payload, LabTime t_received) {
  if (state_ != State::streaming)
    return health_.rejected({Reason::unexpected, "frame while none was expected: ignored"});
  const auto frame = decode_data(payload);
  if (!frame) return health_.rejected(frame.fault());
  if (!frame->has_bodies)
    return health_.rejected({Reason::unexpected, "frame without the rigid bodies that were asked for"});
  if (!is_new(*frame)) return;
  if (frame->body_count != list_.size()) {
    health_.rejected({Reason::bad_value, kWrongCountAdvice});
    wrong_count_ = true;
    lose_all(t_received);
    advise();
    if (t_received - t_list_ >= kListPause) read_bodies(false, t_received);
    return;
  }
  publish(*frame, t_received);
}

/// Whether the frame is newer than the last, or the first of a measurement that started again. The time stamp
/// decides: the frame number stands still in some live modes, and its gaps are normal.
bool QualisysDriver::is_new(const DataFrame& frame) {
  if (has_last_ && frame.timestamp_us == last_.timestamp_us) {
    health_.rejected({Reason::duplicate, "frame came twice"});
    return false;
  }
  if (has_last_ && frame.timestamp_us < last_.timestamp_us) {
    const bool far_back = last_.timestamp_us - frame.timestamp_us > kRestart_us;
    const bool confirmed = far_back && restart_us_ && frame.timestamp_us > *restart_us_ &&
                           frame.timestamp_us - *restart_us_ < kRestart_us;
    if (!confirmed) {
      restart_us_ = far_back ? std::optional{frame.timestamp_us} : std::nullopt;
      health_.rejected({Reason::out_of_order, "frame is older than the one before"});
      return false;
    }
    forget_time();
  }
  if (has_last_ && frame.frame_number > last_.frame_number)
    health_.lost(frame.frame_number - last_.frame_number - 1);
  restart_us_.reset();
  last_ = frame;
  has_last_ = true;
  return true;
}

void QualisysDriver::publish(const DataFrame& frame, LabTime t_received) {
  const auto* camera = frame.timecode ? std::get_if<CameraTime>(&*frame.timecode) : nullptr;
  if (std::exchange(has_camera_time_, camera != nullptr) != (camera != nullptr)) clock_.reset();
  const Nanoseconds t_device =
      camera ? camera->since_epoch : Nanoseconds{static_cast<std::int64_t>(frame.timestamp_us) * 1000};
  t_measured_ = clock_.map(t_device, t_received);
  t_frame_ = t_received;
  showing_ = true;
  health_.accepted(t_measured_, t_received);
  if (silent_ || wrong_count_) {
    silent_ = wrong_count_ = false;
    advise();
  }
  for (Wanted& body : wanted_)
    tell(body, body.index ? frame.body[*body.index] : BodyPose{}, frame, t_measured_, t_received);
}

void QualisysDriver::tell(Wanted& body, const BodyPose& pose, const DataFrame& frame, LabTime t_measured,
                          LabTime t_received) {
  topic::Bodies sample;
  sample.device = config_.device;
  sample.body = body.name;
  sample.sequence_number = ++body.sequence_number;
  sample.t_measured_ns = to_ns(t_measured);
  sample.t_received_ns = to_ns(t_received);
  sample.frame_number = frame.frame_number;
  sample.tracked = pose.tracked;
  sample.p_camera_body_m = pose.p_camera_body_m;
  sample.q_camera_body = pose.q_camera_body;
  sample.residual_m = pose.residual_m;
  sample.drop_rate = frame.drop_rate;
  sample.out_of_sync_rate = frame.out_of_sync_rate;
  sink_(sample);
}

/// Says once of every body that it is not seen any more. Stamped with the first exposure that is missing, so
/// that stamps never go back, even when a stalled network still holds frames.
void QualisysDriver::lose_all(LabTime now) {
  if (!std::exchange(showing_, false)) return;
  const LabTime t_measured = std::min(t_measured_ + from_seconds(config_.frame_period_s), now);
  for (Wanted& body : wanted_) tell(body, BodyPose{}, last_, t_measured, now);
}

void QualisysDriver::forget_time() noexcept {
  clock_.reset();
  has_last_ = false;
  restart_us_.reset();
}

void QualisysDriver::advise() noexcept {
  if (list_refused_) return health_.advice(kNoListAdvice);
  if (state_ == State::idle) return health_.advice(kIdleAdvice);
  if (wrong_count_) return health_.advice(kWrongCountAdvice);
  if (silent_) return health_.advice(kSilentAdvice);
  for (const Wanted& body : wanted_) {
    if (!body.index) return health_.advice(body.missing_advice);
    if (!body.enabled) return health_.advice(body.disabled_advice);
  }
  health_.advice({});
}

}  // namespace motionlab::qualisys
