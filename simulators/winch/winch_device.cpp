#include "simulators/winch/winch_device.hpp"

#include <algorithm>

namespace motionlab::winch {

namespace {

constexpr std::size_t kAnswerMax = 64 * 1024;
constexpr std::size_t kClientsMax = 256;
constexpr std::uint32_t kMovedByOnlineChange = 256;
constexpr std::uint32_t kAnotherLayout = 99;

constexpr std::string_view kUnknownFault =
    "unknown fault; the winch knows: off stuck garbage wrong slow delayed intermittent silent drop_route "
    "stop_plc online_change frozen_cycle drive_fault watchdog_trip router_error ads_error other_layout "
    "close_mid_frame outlier_100ms";

}  // namespace

WinchDevice::WinchDevice(DeviceConfig config, ServerOut& out)
    : config_(std::move(config)),
      out_(out),
      plc_(config_.plc),
      legacy_(config_.plc),
      symbols_(config_.project),
      random_(config_.seed, "winch/garbage"),
      data_(kAnswerMax),
      item_(kAnswerMax),
      frame_(kAnswerMax + kFrameHeaderSize + 64) {}

// Connections

WinchDevice::Session* WinchDevice::find(SessionId id) {
  const auto found =
      std::find_if(sessions_.begin(), sessions_.end(), [&](const Session& s) { return s.id == id; });
  return found == sessions_.end() ? nullptr : &*found;
}

void WinchDevice::drop(SessionId id) {
  out_.close(id);
  std::erase_if(sessions_, [&](const Session& s) { return s.id == id; });
}

void WinchDevice::on_accepted(SessionId id, Endpoint from, LabTime t) {
  now_ = t;
  if (config_.one_connection_per_address) {
    const auto older = std::find_if(sessions_.begin(), sessions_.end(),
                                    [&](const Session& s) { return s.from.address == from.address; });
    if (older != sessions_.end()) drop(older->id);
  }
  sessions_.push_back({id, from});
}

void WinchDevice::on_closed(SessionId id, LabTime t) {
  now_ = t;
  std::erase_if(sessions_, [&](const Session& s) { return s.id == id; });
}

void WinchDevice::on_bytes(SessionId id, Bytes bytes, LabTime t_received) {
  now_ = t_received;
  if (faults_.common.off()) return;
  Session* session = find(id);
  if (session == nullptr) return;
  session->splitter.append(bytes);
  while ((session = find(id)) != nullptr) {  // serving a frame may have closed the session
    const auto next = session->splitter.next();
    if (!next) {
      ++malformed_;
      drop(id);
      return;
    }
    if (!*next) return;
    const TcpFrame frame = **next;
    if (faults_.drop_route) {
      drop(id);
    } else if (frame.command != TcpCommand::ads) {
      serve_local(*session, frame);
    } else if (const auto ams = decode_ams(frame.body)) {
      serve(*session, *ams);
    } else {
      ++malformed_;
      drop(id);
    }
  }
}

void WinchDevice::serve_local(Session& session, const TcpFrame& frame) {
  if (frame.command != TcpCommand::port_connect && frame.command != TcpCommand::port_close) return;
  if (frame.body.size() != sizeof(std::uint16_t)) {
    ++malformed_;
    return;
  }
  const auto wanted = load<std::uint16_t, std::endian::little>(frame.body);
  if (frame.command == TcpCommand::port_close) {  // the answer of a router is to close the connection
    const AmsAddress closed{config_.net_id, wanted};
    std::erase_if(subscriptions_, [&](const Subscription& s) { return s.client == closed; });
    drop(session.id);
    return;
  }
  LittleWriter body{data_};
  body.write_bytes(config_.net_id.numbers);
  body.write(wanted != 0 ? wanted : next_port_++);
  if (const auto reply = encode_tcp_frame(frame_, TcpCommand::port_connect, body.written())) {
    transmit(session, *reply);
  }
}

bool WinchDevice::has_route(const NetId& source) const {
  return config_.routes.empty() || source == config_.net_id ||
         std::find(config_.routes.begin(), config_.routes.end(), source) != config_.routes.end();
}

std::uint32_t WinchDevice::routing_error(const AmsAddress& target) const {
  if (target.net_id != config_.net_id) return ads_error::machine_not_found;
  if (target.port == ams_port::system_service) return ads_error::none;
  const bool there = target.port == config_.plc_port && state_ != AdsState::config;
  return there ? faults_.router_error : ads_error::port_not_found;
}

void WinchDevice::remember(const AmsAddress& client, SessionId session) {
  const auto known =
      std::find_if(clients_.begin(), clients_.end(), [&](const Client& c) { return c.address == client; });
  if (known != clients_.end()) {
    known->session = session;
    return;
  }
  if (clients_.size() >= kClientsMax) clients_.erase(clients_.begin());
  clients_.push_back({client, session});
}

// Time

void WinchDevice::cycle(LabTime t, const Measurement& measurement) {
  now_ = t;
  if (config_.project == PlcProject::legacy && state_ == AdsState::run && !faults_.common.off()) {
    legacy_.command(t, plc_);
  }
  plc_.cycle(t, measurement, seen(measurement));
  legacy_.report(plc_);
  if (faults_.other_layout) {
    store<std::endian::little>(plc_.memory().subspan(PlcProgram::kStatusAt), kAnotherLayout);
  }
  if (!faults_.common.off()) notify(t);
}

/// What the sensors say of what is.
Measurement WinchDevice::seen(const Measurement& is) {
  Measurement seen = is;
  if (faults_.common.stuck()) {
    if (!stuck_at_) stuck_at_ = is;
    seen = *stuck_at_;
  } else {
    stuck_at_.reset();
  }
  const double off_by = faults_.common.wrong_by();
  seen.wire_length_m += off_by;
  seen.wire_speed_mps += off_by;
  seen.motor_torque_nm += off_by;
  seen.motor_temperature_degc += off_by;
  return seen;
}

void WinchDevice::step(LabTime now) {
  now_ = now;
  for (auto& session : sessions_) {
    while (!session.held.empty() && session.held.front().due <= now) {
      (void)out_.send(session.id, session.held.front().bytes);  // a peer that is gone is told by on_closed
      session.held.pop_front();
    }
  }
}

// Sending

void WinchDevice::transmit(Session& session, Bytes frame) {
  if (faults_.silent || !faults_.common.speaks(now_)) return;
  ++frames_sent_;
  if (faults_.common.garbage()) {
    const auto noise = MutableBytes{frame_}.first(frame.size());
    for (auto& byte : noise) byte = static_cast<std::uint8_t>(random_.below(256));
    frame = noise;
  }
  if (faults_.close_mid_frame) {
    faults_.close_mid_frame = false;
    (void)out_.send(session.id, frame.first(frame.size() / 2));
    drop(session.id);
    return;
  }
  Nanoseconds delay = faults_.common.delay();
  if (faults_.outlier_every && frames_sent_ % *faults_.outlier_every == 0) delay += 100ms;
  send_or_hold(session, frame, delay);
}

void WinchDevice::send_or_hold(Session& session, Bytes bytes, Nanoseconds delay) {
  if (session.held.empty() && delay == Nanoseconds{0}) {
    (void)out_.send(session.id, bytes);  // a peer that is gone is told by on_closed
    return;
  }
  LabTime due = now_ + delay;
  if (!session.held.empty()) due = std::max(due, session.held.back().due);
  session.held.push_back({due, ByteBuffer{bytes.begin(), bytes.end()}});
}

// Faults

void WinchDevice::set_state(AdsState state) {
  state_ = state;
  plc_.run(state == AdsState::run && !faults_.common.off());
}

void WinchDevice::change_online() {
  ++symbol_version_;
  data_at_ += kMovedByOnlineChange;
  for (auto& handle : handles_) handle.valid = false;
  const auto is_void = [](const Subscription& s) {
    return s.item.index_group == index_group::value_by_handle;
  };
  for (auto& subscription : subscriptions_) {
    if (is_void(subscription)) send_sample(subscription, {});
  }
  std::erase_if(subscriptions_, is_void);
}

/// Cuts the power, or gives it back: then everything that was kept for clients is forgotten.
void WinchDevice::power(bool off) {
  if (off) {
    for (auto& session : sessions_) session.held.clear();
    plc_.lose_power();
    return;
  }
  while (!sessions_.empty()) drop(sessions_.back().id);
  clients_.clear();
  subscriptions_.clear();
  handles_.clear();
  legacy_ = LegacyProgram{config_.plc};
  set_state(AdsState::run);
}

std::string_view WinchDevice::fault_names() noexcept {
  return kUnknownFault.substr(kUnknownFault.find(':') + 2);
}

Status WinchDevice::set_fault(std::string_view name, bool active, double value) {
  const auto code = [&](std::uint32_t otherwise) {
    if (!active) return ads_error::none;
    return value >= 1 && value <= 4294967295.0 ? static_cast<std::uint32_t>(value) : otherwise;
  };
  const bool was_off = faults_.common.off();
  if (faults_.common.set(name, active, value)) {
    if (faults_.common.off() != was_off) power(faults_.common.off());
  } else if (name == "silent") {
    faults_.silent = active;
  } else if (name == "drop_route") {
    faults_.drop_route = active;
    while (active && !sessions_.empty()) drop(sessions_.back().id);
  } else if (name == "stop_plc") {
    const bool config = value == static_cast<double>(AdsState::config);
    set_state(!active ? AdsState::run : config ? AdsState::config : AdsState::stop);
  } else if (name == "online_change") {
    if (active) change_online();
  } else if (name == "frozen_cycle") {
    plc_.freeze_cycle_count(active);
  } else if (name == "drive_fault") {
    constexpr std::uint32_t kSomeFault = 0xF000;
    plc_.drive_fault(active ? std::optional{code(kSomeFault)} : std::nullopt);
  } else if (name == "watchdog_trip") {
    plc_.trip_watchdog(active);
  } else if (name == "router_error") {
    faults_.router_error = code(ads_error::port_not_found);
  } else if (name == "ads_error") {
    faults_.ads_error = code(ads_error::busy);
  } else if (name == "other_layout") {
    faults_.other_layout = active;
  } else if (name == "close_mid_frame") {
    faults_.close_mid_frame = active;
  } else if (name == "outlier_100ms") {
    faults_.outlier_every.reset();
    if (active) faults_.outlier_every = value >= 1 ? static_cast<std::uint64_t>(value) : 50;
  } else {
    return Fault{Reason::refused, kUnknownFault};
  }
  return Done{};
}

}  // namespace motionlab::winch
