#include "drivers/winch/winch_driver.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace motionlab::winch {

namespace {

constexpr std::size_t kBodyMax = 64 * 1024;  // nothing we ask for has a longer answer
constexpr std::uint32_t kTimeoutsMax = 3;
constexpr double kAtRestMps = 0.005;
constexpr Nanoseconds kRestPatience = 3s;
constexpr Nanoseconds kDisablePatience = 1s;
constexpr Nanoseconds kDeletePeriod = 100ms;
constexpr Nanoseconds kResolveOncePer = 1s;

constexpr std::string_view kRefused =
    "winch controller refuses the TCP connection: check its address, that TwinCAT runs, and that plain ADS "
    "(48898) "
    "is allowed";
constexpr std::string_view kNoAnswer = "winch controller does not answer: check power, cable and address";
constexpr std::string_view kBroken = "connection to the winch controller broke; connecting again";
constexpr std::string_view kMalformed =
    "winch controller sent a malformed frame: is the address that of an ADS port?";
constexpr std::string_view kPortNotFound =
    "winch PLC runtime is not there (AMS error 6): log in with TwinCAT and set the PLC to run";
constexpr std::string_view kNotRun = "winch PLC is not in run: start it from TwinCAT";
constexpr std::string_view kSystemNotRun =
    "TwinCAT system on the winch controller is not in run: set it to run mode";
constexpr std::string_view kWrongProject =
    "winch PLC project lacks GVL_Winch: download the project that has stCommand and stStatus";
constexpr std::string_view kLayout =
    "winch PLC structs are not ours (size, type or layout version): align gateway and PLC project, then "
    "restart";
constexpr std::string_view kOtherError =
    "winch controller refuses a request; see the ADS error code in the log";
constexpr std::string_view kStandsStill = "winch status stands still: is the PLC task running?";
constexpr std::string_view kWatchdog =
    "winch watchdog tripped (heartbeat lost): settle, reset, then enable again";
constexpr std::string_view kDriveFault =
    "winch drive or axis fault: read the diagnosis, remove the cause, then reset";
constexpr std::string_view kCommandPath =
    "winch does not echo our heartbeat: does another client command it?";

constexpr Fault kTimedOut{Reason::transport, "the winch controller did not answer a request in time"};
constexpr Fault kNotOurs{Reason::foreign, "ADS frame that is not from the winch PLC, or not for us"};
constexpr Fault kBounced{Reason::unexpected,
                         "a router sent our own request back: check the route on the controller"};
constexpr Fault kUnasked{Reason::unexpected, "ADS answer to no open request (late, or not ours)"};
constexpr Fault kUnknownNotification{Reason::unexpected,
                                     "notification of a handle that is not ours; deleting it"};
constexpr Fault kOddSample{Reason::bad_header, "notification sample of another size than subscribed"};
constexpr Fault kAnswerError{Reason::refused, "the winch controller answered with an ADS error"};

PlcMode to_plc(topic::WinchCommandMode mode) noexcept {
  switch (mode) {
    case topic::WinchCommandMode::off:
      return PlcMode::off;
    case topic::WinchCommandMode::hold:
      return PlcMode::hold;
    case topic::WinchCommandMode::velocity:
      return PlcMode::velocity;
    case topic::WinchCommandMode::position:
      return PlcMode::position;
  }
  return PlcMode::off;
}

}  // namespace

WinchDriver::WinchDriver(DriverConfig config, StreamOut& out, Sink<topic::WinchState> sink)
    : config_(std::move(config)),
      out_(out),
      sink_(std::move(sink)),
      clock_({.latency = from_seconds(config_.latency_s)}),
      splitter_(kBodyMax),
      advice_route_("winch controller closed the connection at our first request: it has no route to NetId " +
                    to_string(config_.local.net_id) + "; add one in TwinCAT"),
      advice_net_id_("winch controller does not know the AMS NetId " + to_string(config_.target.net_id) +
                     " (AMS error 7): correct the target NetId"),
      backoff_s_(config_.reconnect_min_s),
      jitter_(config_.jitter_seed) {}

double WinchDriver::to_axis(double wire_length_m) const noexcept {
  return config_.pay_out_sign * (wire_length_m - config_.wire_at_zero_travel_m);
}

double WinchDriver::to_wire(double position_m) const noexcept {
  return config_.wire_at_zero_travel_m + config_.pay_out_sign * position_m;
}

Status WinchDriver::set_command(const topic::WinchCommand& command) {
  const auto refuse = [&](Fault fault) -> Status {
    health_.rejected(fault);
    return fault;
  };
  if (!command.device.empty() && command.device.view() != config_.device) {
    return refuse({Reason::foreign, "winch command for another device"});
  }
  if (!std::isfinite(command.wire_length_wanted_m) || !std::isfinite(command.wire_speed_wanted_mps) ||
      !std::isfinite(command.wire_acceleration_wanted_mps2)) {
    return refuse({Reason::bad_value, "winch command that is not finite"});
  }
  if (t_command_ && command.t_created_ns < command_.t_created_ns) {
    return refuse({Reason::out_of_order, "winch command older than the one in use"});
  }
  command_ = command;
  t_command_ = std::min(from_ns(command.t_created_ns), now_);
  const bool in_touch = stage_ == Stage::running && health_.phase() == LinkPhase::up;
  arming_.wish(command.enable, command.reset, in_touch, now_);
  return Done{};
}

// The link

void WinchDriver::step(LabTime now) {
  now_ = now;
  switch (stage_) {
    case Stage::idle:
      open(now);
      break;
    case Stage::waiting:
      if (now >= retry_at_) open(now);
      break;
    case Stage::opening:
      if (now - t_opened_ >= from_seconds(config_.connect_timeout_s)) lose_link(kNoAnswer, now);
      break;
    case Stage::setting_up:
      check_timeouts();
      if (stage_ == Stage::setting_up && step_due_ && now >= retry_at_) send_step();
      break;
    case Stage::running:
      check_timeouts();
      if (stage_ == Stage::running) check_status_age();
      if (stage_ == Stage::running && stopping_ != Stopping::no) follow_stop();
      if (stage_ == Stage::running && now >= next_command_) write_command();
      break;
    case Stage::halted:
    case Stage::ended:
      break;
  }
}

void WinchDriver::open(LabTime now) {
  stage_ = Stage::opening;
  t_opened_ = now;
  health_.phase(LinkPhase::connecting);
  out_.open();
}

void WinchDriver::on_open(LabTime t) {
  now_ = t;
  if (stage_ != Stage::opening) return;
  if (++opens_ > 1) health_.reconnected();
  splitter_.reset();
  clock_.reset();
  pending_ = {};
  timeouts_in_a_row_ = 0;
  heard_anything_ = false;
  symbol_version_.reset();
  t_resolved_again_.reset();
  written_ = {.sequence = written_.sequence};
  stage_ = Stage::setting_up;
  step_ = Step::system_state;
  send_step();
}

void WinchDriver::on_closed(std::string_view, LabTime t) {
  now_ = t;
  if (stage_ == Stage::halted || stage_ == Stage::ended) return;
  lose_link(stage_ == Stage::opening ? kRefused
            : heard_anything_        ? kBroken
                                     : std::string_view{advice_route_},
            t);
}

void WinchDriver::lose_link(std::string_view advice, LabTime now) {
  out_.close();
  splitter_.reset();
  pending_ = {};
  status_.reset();
  arming_.disarm();
  health_.phase(LinkPhase::down);
  health_.advice(advice);
  if (stopping_ != Stopping::no) {  // the PLC's watchdog stops the winch; there is nobody left to talk to
    stage_ = Stage::ended;
    return;
  }
  jitter_ = jitter_ * 1664525U + 1013904223U;
  const double spread = 0.75 + 0.5 * static_cast<double>(jitter_ >> 8) / static_cast<double>(1U << 24);
  stage_ = Stage::waiting;
  retry_at_ = now + from_seconds(backoff_s_ * spread);
  backoff_s_ = std::min(2.0 * backoff_s_, config_.reconnect_max_s);
}

void WinchDriver::halt(Fault fault) {
  health_.rejected(fault);
  health_.advice(kLayout);
  health_.phase(LinkPhase::down);
  arming_.disarm();
  pending_ = {};
  splitter_.reset();
  out_.close();
  stage_ = Stage::halted;
}

void WinchDriver::finish() {
  out_.close();
  splitter_.reset();
  pending_ = {};
  health_.phase(LinkPhase::down);
  stage_ = Stage::ended;
}

// Requests

template <class Message>
void WinchDriver::request(Purpose purpose, AdsCommand command, const Message& message, std::uint16_t port) {
  const auto slot = std::find_if(pending_.begin(), pending_.end(),
                                 [](const Pending& p) { return p.purpose == Purpose::none; });
  if (slot == pending_.end()) return;  // all eight unanswered: the timeouts are about to close the connection
  AmsHeader header;
  header.target = config_.target;
  if (port != 0) header.target.port = port;
  header.source = config_.local;
  header.command = static_cast<std::uint16_t>(command);
  header.invoke_id = ++invoke_id_;
  const auto frame = encode_frame(frame_, header, message);
  if (!frame) {
    health_.rejected(frame.fault());
    return;
  }
  *slot = {purpose, command, header.invoke_id, now_};
  if (const auto sent = out_.send(*frame); !sent) health_.rejected(sent.fault());
}

bool WinchDriver::waiting_for(Purpose purpose) const noexcept {
  return std::any_of(pending_.begin(), pending_.end(),
                     [&](const Pending& p) { return p.purpose == purpose; });
}

void WinchDriver::check_timeouts() {
  bool repeat_step = false;
  for (auto& pending : pending_) {
    if (pending.purpose == Purpose::none || now_ - pending.t_sent < from_seconds(config_.request_timeout_s))
      continue;
    repeat_step = repeat_step || pending.purpose == Purpose::set_up;
    pending = {};
    ++counters_.timeouts;
    ++timeouts_in_a_row_;
    health_.rejected(kTimedOut);
  }
  if (timeouts_in_a_row_ >= kTimeoutsMax) {
    lose_link(kNoAnswer, now_);
  } else if (repeat_step) {
    step_due_ = true;
    retry_at_ = now_;
  }
}

// Setting up: one request at a time

void WinchDriver::send_step() {
  step_due_ = false;
  const auto set_up = [&](AdsCommand command, const auto& message, std::uint16_t port = 0) {
    request(Purpose::set_up, command, message, port);
  };
  const auto ask_name = [&](std::uint32_t group, std::uint32_t length, std::string_view symbol) {
    set_up(AdsCommand::read_write, ReadWriteRequest{group, 0, length, as_bytes(symbol)});
  };
  constexpr std::uint32_t kEntryMax = 4096;
  switch (step_) {
    case Step::system_state:
      set_up(AdsCommand::read_state, NoData{}, ams_port::system_service);
      break;
    case Step::plc_state:
      set_up(AdsCommand::read_state, NoData{});
      break;
    case Step::device_info:
      set_up(AdsCommand::read_device_info, NoData{});
      break;
    case Step::command_symbol:
      ask_name(index_group::info_by_name_ex, kEntryMax, config_.command_symbol);
      break;
    case Step::status_symbol:
      ask_name(index_group::info_by_name_ex, kEntryMax, config_.status_symbol);
      break;
    case Step::command_handle:
      ask_name(index_group::handle_by_name, 4, config_.command_symbol);
      break;
    case Step::status_handle:
      ask_name(index_group::handle_by_name, 4, config_.status_symbol);
      break;
    case Step::first_status:
      set_up(AdsCommand::read, ReadRequest{index_group::value_by_handle, status_handle_, kStatusSize});
      break;
    case Step::subscribe_version:
      set_up(AdsCommand::add_notification,
             AddNotificationRequest{index_group::symbol_version, 0, 1,
                                    static_cast<std::uint32_t>(NotificationMode::on_change), Nanoseconds{0},
                                    Nanoseconds{0}});
      break;
    case Step::subscribe_status:
      set_up(AdsCommand::add_notification,
             AddNotificationRequest{index_group::value_by_handle, status_handle_, kStatusSize,
                                    static_cast<std::uint32_t>(NotificationMode::cyclic), Nanoseconds{0},
                                    from_seconds(config_.status_period_s)});
      break;
    case Step::done:
      break;
  }
}

/// Stays connected and asks from the beginning after a while.
void WinchDriver::retry_set_up(std::string_view advice) {
  health_.advice(advice);
  stage_ = Stage::setting_up;
  step_ = Step::system_state;
  step_due_ = true;
  retry_at_ = now_ + from_seconds(backoff_s_);
  backoff_s_ = std::min(2.0 * backoff_s_, config_.reconnect_max_s);
}

void WinchDriver::take_step(const AmsFrame& frame) {
  const auto answered = [&](const auto& response) {
    if (!response) {
      health_.rejected(response.fault());
      lose_link(kMalformed, now_);
      return false;
    }
    if (response->result == ads_error::none) return true;
    take_error(ErrorReport::Level::ads, response->result, Purpose::set_up,
               static_cast<AdsCommand>(frame.header.command));
    return false;
  };
  switch (step_) {
    case Step::system_state:
    case Step::plc_state: {
      const auto state = ReadStateResponse::decode(frame.data);
      if (!answered(state)) return;
      if (state->ads_state != AdsState::run) {
        retry_set_up(step_ == Step::system_state ? kSystemNotRun : kNotRun);
        return;
      }
      break;
    }
    case Step::device_info: {
      const auto info = DeviceInfoResponse::decode(frame.data);
      if (!answered(info)) return;
      device_info_ = *info;
      delete_notifications();  // those of the connection before outlive it
      break;
    }
    case Step::command_symbol:
    case Step::status_symbol: {
      const auto answer = ReadResponse::decode(frame.data);
      if (!answered(answer)) return;
      const auto checked = step_ == Step::command_symbol
                               ? check_symbol(answer->data, kCommandSize, kCommandType)
                               : check_symbol(answer->data, kStatusSize, kStatusType);
      if (!checked) {
        halt(checked.fault());
        return;
      }
      break;
    }
    case Step::command_handle:
    case Step::status_handle: {
      const auto answer = ReadResponse::decode(frame.data);
      if (!answered(answer)) return;
      if (answer->data.size() != sizeof(std::uint32_t)) {
        health_.rejected({Reason::bad_header, "a symbol handle has 4 bytes"});
        lose_link(kMalformed, now_);
        return;
      }
      const auto handle = load<std::uint32_t, std::endian::little>(answer->data);
      (step_ == Step::command_handle ? command_handle_ : status_handle_) = handle;
      break;
    }
    case Step::first_status: {
      const auto answer = ReadResponse::decode(frame.data);
      if (!answered(answer)) return;
      const auto status = PlcStatus::decode(answer->data);
      if (!status && status.fault().reason != Reason::bad_value) {
        halt(status.fault());
        return;
      }
      if (!status) {
        health_.rejected(status.fault());
        retry_set_up(kStandsStill);
        return;
      }
      // Only a reference: it may be as old as the PLC's last stop. What advances beyond it is told.
      status_ = *status;
      heartbeat_.restart(status->heartbeat_echo);
      arming_.heard(*status, now_);
      break;
    }
    case Step::subscribe_version:
    case Step::subscribe_status: {
      const auto answer = AddNotificationResponse::decode(frame.data);
      if (!answered(answer)) return;
      (step_ == Step::subscribe_version ? version_notification_ : status_notification_) = answer->handle;
      break;
    }
    case Step::done:
      return;
  }
  step_ = static_cast<Step>(static_cast<std::uint8_t>(step_) + 1);
  if (step_ == Step::done) {
    start_running();
  } else {
    send_step();
  }
}

Status WinchDriver::check_symbol(Bytes answer, std::size_t size, std::string_view type) {
  const auto entry = SymbolEntry::decode(answer);
  if (!entry) return entry.fault();
  if (entry->place.size != size)
    return Fault{Reason::bad_header, "a winch struct of the PLC has another size"};
  if (!same_name(entry->type, type))
    return Fault{Reason::bad_header, "a winch symbol of the PLC has another type"};
  return Done{};
}

void WinchDriver::start_running() {
  stage_ = Stage::running;
  t_fresh_ = now_;
  next_read_ = now_;
  next_command_ = now_;
}

/// The PLC was changed while we are connected: ask for handles anew, once; if that does not help, connect
/// anew.
void WinchDriver::resolve_again() {
  if (t_resolved_again_ && now_ - *t_resolved_again_ < kResolveOncePer) {
    lose_link(kWrongProject, now_);
    return;
  }
  t_resolved_again_ = now_;
  ++counters_.resolved_again;
  for (auto& pending : pending_) {
    if (pending.purpose == Purpose::set_up) pending = {};
  }
  clean_up();
  symbol_version_.reset();
  stage_ = Stage::setting_up;
  step_ = Step::command_symbol;
  send_step();
}

void WinchDriver::delete_notifications() {
  for (auto* handle : {&status_notification_, &version_notification_}) {
    if (*handle != 0) {
      request(Purpose::clean_up, AdsCommand::delete_notification, DeleteNotificationRequest{*handle});
    }
    *handle = 0;
  }
}

/// Gives back what the PLC keeps for us.
void WinchDriver::clean_up() {
  delete_notifications();
  for (const auto handle : {command_handle_, status_handle_}) {
    std::array<std::uint8_t, sizeof(handle)> bytes{};
    store<std::endian::little>(bytes, handle);
    request(Purpose::clean_up, AdsCommand::write, WriteRequest{index_group::release_handle, 0, bytes});
  }
}

// Running

void WinchDriver::write_command() {
  const auto period = from_seconds(config_.command_period_s);
  next_command_ += period;
  if (next_command_ <= now_) next_command_ += period * ((now_ - next_command_) / period + 1);
  if (stopping_ == Stopping::cleaning) return;
  if (waiting_for(Purpose::write_command)) {
    ++counters_.commands_skipped;
    return;
  }
  const Arming::Bits bits = arming_.bits();
  PlcCommand command = command_for(bits);
  const bool changed = command.mode != written_.mode || command.enable != written_.enable ||
                       command.reset != written_.reset || command.quick_stop != written_.quick_stop;
  command.heartbeat = heartbeat_.next();
  command.sequence = written_.sequence + (changed ? 1U : 0U);
  std::array<std::uint8_t, kCommandSize> bytes{};
  LittleWriter writer{bytes};
  command.encode(writer);
  request(Purpose::write_command, AdsCommand::write,
          WriteRequest{index_group::value_by_handle, command_handle_, bytes});
  heartbeat_.sent(now_);
  arming_.written({command.enable, command.reset}, command.heartbeat);
  written_ = command;
  ++counters_.commands_written;
}

PlcCommand WinchDriver::command_for(Arming::Bits bits) {
  const bool stale = !t_command_ || now_ - *t_command_ > from_seconds(config_.command_stale_after_s);
  if (stale && !command_stale_ && t_command_) ++counters_.commands_stale;
  command_stale_ = stale;

  PlcCommand command;
  command.enable = bits.enable;
  command.reset = bits.reset;
  command.torque_limit_nm = config_.torque_limit_nm;
  command.timeout = std::chrono::milliseconds{std::llround(1e3 * config_.plc_watchdog_s)};
  command.position_m = status_ ? status_->set_position_m : 0.0;
  command.mode = t_command_ ? PlcMode::hold : PlcMode::off;
  if (stopping_ != Stopping::no) {
    command.quick_stop = true;
    command.enable = written_.enable && stopping_ == Stopping::braking;
    command.reset = false;
  } else if (stale) {
    command.quick_stop = true;
  } else {
    command.mode = to_plc(command_.mode);
    command.velocity_mps = config_.pay_out_sign * command_.wire_speed_wanted_mps;
    command.acceleration_mps2 = config_.pay_out_sign * command_.wire_acceleration_wanted_mps2;
    if (command.mode == PlcMode::position) command.position_m = to_axis(command_.wire_length_wanted_m);
  }
  return command;
}

void WinchDriver::check_status_age() {
  const auto age = now_ - t_fresh_;
  if (age <= from_seconds(config_.status_stale_after_s)) return;
  if (age > from_seconds(config_.status_dead_after_s)) {
    lose_link(kStandsStill, now_);
    return;
  }
  health_.advice(kStandsStill);
  if (now_ < next_read_ || waiting_for(Purpose::read_status)) return;
  next_read_ = now_ + from_seconds(config_.status_stale_after_s);
  request(Purpose::read_status, AdsCommand::read,
          ReadRequest{index_group::value_by_handle, status_handle_, kStatusSize});
}

void WinchDriver::orderly_stop() {
  if (stopping_ != Stopping::no || stage_ == Stage::ended) return;
  if (stage_ != Stage::running) {
    finish();
    return;
  }
  stopping_ = Stopping::braking;
  t_stopping_ = now_;
  stop_heartbeat_ = heartbeat_.next();
}

void WinchDriver::follow_stop() {
  const auto begin = [&](Stopping next) {
    stopping_ = next;
    t_stopping_ = now_;
    stop_heartbeat_ = heartbeat_.next();
  };
  const bool heard = status_ && static_cast<std::int32_t>(status_->heartbeat_echo - stop_heartbeat_) >= 0;
  const auto waited = now_ - t_stopping_;
  switch (stopping_) {
    case Stopping::no:
      break;
    case Stopping::braking: {
      const bool holding = heard && status_->state != PlcState::velocity &&
                           status_->state != PlcState::position && status_->state != PlcState::stopping;
      if ((holding && std::abs(status_->velocity_mps) < kAtRestMps) || waited > kRestPatience) {
        begin(Stopping::disabling);
      }
      break;
    }
    case Stopping::disabling:
      if ((heard && !status_->enabled) || waited > kDisablePatience) {
        begin(Stopping::cleaning);
        clean_up();
      }
      break;
    case Stopping::cleaning:
      if (!waiting_for(Purpose::clean_up)) finish();
      break;
  }
}

// What arrives

void WinchDriver::on_bytes(Bytes bytes, LabTime t_received) {
  now_ = t_received;
  splitter_.append(bytes);
  while (stage_ == Stage::setting_up || stage_ == Stage::running) {
    const auto next = splitter_.next();
    if (!next) {
      health_.rejected(next.fault());
      lose_link(kMalformed, t_received);
      return;
    }
    if (!*next) return;
    if ((**next).command != TcpCommand::ads) {
      health_.rejected({Reason::unexpected, "a frame for programs on the controller's own host"});
      continue;
    }
    const auto frame = decode_ams((**next).body);
    if (!frame) {
      health_.rejected(frame.fault());
      lose_link(kMalformed, t_received);
      return;
    }
    take_frame(*frame, t_received);
  }
}

void WinchDriver::take_frame(const AmsFrame& frame, LabTime t) {
  const AmsHeader& header = frame.header;
  if (header.source == config_.local && !header.is_response()) {
    health_.rejected(kBounced);
    return;
  }
  if (header.target != config_.local || header.source.net_id != config_.target.net_id) {
    health_.rejected(kNotOurs);
    return;
  }
  heard_anything_ = true;
  if (header.command == static_cast<std::uint16_t>(AdsCommand::notification)) {
    take_notification(frame, t);
  } else {
    take_answer(frame, t);
  }
}

void WinchDriver::take_notification(const AmsFrame& frame, LabTime t) {
  auto stream = NotificationReader::open(frame.data);
  if (!stream) {
    health_.rejected(stream.fault());
    return;
  }
  NotificationReader samples = *stream;
  while (const auto item = samples.next()) {
    const NotificationSample& sample = item->sample;
    const bool during_set_up = stage_ == Stage::setting_up;  // subscriptions are being made or given up
    if (!during_set_up && sample.handle == status_notification_) {
      if (sample.data.empty()) {
        resolve_again();
        return;
      }
      if (sample.data.size() == kStatusSize) {
        take_status(sample.data, t);
      } else {
        health_.rejected(kOddSample);
      }
    } else if (sample.handle == version_notification_ &&
               (!during_set_up || step_ == Step::subscribe_status)) {
      if (sample.data.size() != 1) {
        health_.rejected(kOddSample);
        continue;
      }
      const std::uint8_t version = sample.data[0];
      const bool changed = symbol_version_ && *symbol_version_ != version;
      symbol_version_ = version;
      if (changed) {
        resolve_again();
        return;
      }
    } else if (!during_set_up) {
      ++counters_.foreign_notifications;
      health_.rejected(kUnknownNotification);
      if (now_ < next_delete_) continue;
      next_delete_ = now_ + kDeletePeriod;
      request(Purpose::clean_up, AdsCommand::delete_notification, DeleteNotificationRequest{sample.handle});
    }
    if (stage_ != Stage::running && stage_ != Stage::setting_up) return;
  }
}

void WinchDriver::take_answer(const AmsFrame& frame, LabTime t) {
  const auto slot = std::find_if(pending_.begin(), pending_.end(), [&](const Pending& p) {
    return p.purpose != Purpose::none && p.invoke_id == frame.header.invoke_id;
  });
  if (slot == pending_.end() || !frame.header.is_response() ||
      frame.header.command != static_cast<std::uint16_t>(slot->command)) {
    health_.rejected(kUnasked);
    return;
  }
  const Pending pending = std::exchange(*slot, Pending{});
  timeouts_in_a_row_ = 0;
  round_trip_.add(t - pending.t_sent);
  if (frame.header.error != ads_error::none) {
    take_error(ErrorReport::Level::ams, frame.header.error, pending.purpose, pending.command);
    return;
  }
  switch (pending.purpose) {
    case Purpose::none:
      break;
    case Purpose::set_up:
      take_step(frame);
      break;
    case Purpose::clean_up:
      break;  // a handle that is gone already is as good as deleted
    case Purpose::write_command: {
      const auto answer = ResultResponse::decode(frame.data);
      if (!answer) {
        health_.rejected(answer.fault());
      } else if (answer->result != ads_error::none) {
        take_error(ErrorReport::Level::ads, answer->result, pending.purpose, pending.command);
      }
      break;
    }
    case Purpose::read_status: {
      const auto answer = ReadResponse::decode(frame.data);
      if (!answer) {
        health_.rejected(answer.fault());
      } else if (answer->result != ads_error::none) {
        take_error(ErrorReport::Level::ads, answer->result, pending.purpose, pending.command);
      } else if (stage_ == Stage::running) {
        take_status(answer->data, t);
      }
      break;
    }
  }
}

void WinchDriver::take_error(ErrorReport::Level level, std::uint32_t code, Purpose purpose,
                             AdsCommand command) {
  health_.rejected(kAnswerError);
  if (last_error_ && last_error_->code == code && last_error_->level == level) {
    last_error_->t_last = now_;
    ++last_error_->count;
  } else {
    last_error_ = ErrorReport{level, code, command, now_, now_, 1};
  }
  if (purpose == Purpose::clean_up) return;
  switch (describe(code).error_class) {
    case ErrorClass::layout:
      halt({Reason::bad_header, "the PLC says that a size is wrong"});
      return;
    case ErrorClass::resolve_again:
    case ErrorClass::subscribe_again:
      if (stage_ == Stage::running || !t_resolved_again_) {
        resolve_again();
      } else {
        lose_link(kWrongProject, now_);
      }
      return;
    case ErrorClass::offline:
      lose_link(kPortNotFound, now_);
      return;
    case ErrorClass::not_running:
      lose_link(kNotRun, now_);
      return;
    case ErrorClass::configuration:
      lose_link(code == ads_error::machine_not_found ? std::string_view{advice_net_id_} : kOtherError, now_);
      return;
    case ErrorClass::wrong_project:
      lose_link(kWrongProject, now_);
      return;
    case ErrorClass::none:
    case ErrorClass::back_off:
    case ErrorClass::retry:
    case ErrorClass::programming:
    case ErrorClass::leak:
    case ErrorClass::timeout:
    case ErrorClass::unknown:
      health_.advice(kOtherError);
      if (purpose == Purpose::set_up) retry_set_up(kOtherError);
      return;
  }
}

void WinchDriver::take_status(Bytes bytes, LabTime t) {
  const auto decoded = PlcStatus::decode(bytes);
  if (!decoded) {
    if (decoded.fault().reason == Reason::bad_header) {
      halt(decoded.fault());
    } else {
      health_.rejected(decoded.fault());
    }
    return;
  }
  if (status_ && decoded->cycle_count == status_->cycle_count) {
    ++counters_.status_repeated;
    return;
  }
  const auto period_ns = from_seconds(config_.status_period_s).count();
  const auto gap_ns = status_ ? (decoded->t_plc - status_->t_plc).count() : 0;
  if (health_.phase() == LinkPhase::up && gap_ns > period_ns + period_ns / 2) {
    health_.lost(static_cast<std::uint64_t>((gap_ns + period_ns / 2) / period_ns - 1));
  }
  if (gap_ns < 0) clock_.reset();  // the PLC's clock was set back
  status_ = *decoded;
  t_fresh_ = t;
  backoff_s_ = config_.reconnect_min_s;
  health_.phase(LinkPhase::up);
  heartbeat_.echoed(decoded->heartbeat_echo);
  arming_.heard(*decoded, t);
  advise(*decoded);
  tell(*decoded, t);
}

void WinchDriver::advise(const PlcStatus& status) {
  if (status.state == PlcState::communication_lost) {
    health_.advice(kWatchdog);
  } else if (status.state == PlcState::fault || status.error) {
    health_.advice(kDriveFault);
  } else if (counters_.commands_written > 0 && !heartbeat_.alive(now_, from_seconds(1.0)) &&
             now_ - t_opened_ > 1s) {
    health_.advice(kCommandPath);
  } else {
    health_.advice({});
  }
}

void WinchDriver::tell(const PlcStatus& status, LabTime t) {
  const LabTime t_measured = clock_.map(status.t_plc, t);
  health_.accepted(t_measured, t);
  const double a_m = to_wire(status.position_min_m);
  const double b_m = to_wire(status.position_max_m);
  const bool reversed = config_.pay_out_sign < 0;

  topic::WinchState state;
  state.device = config_.device;
  state.sequence_number = ++told_;
  state.t_measured_ns = to_ns(t_measured);
  state.t_received_ns = to_ns(t);
  state.drive_state = static_cast<topic::WinchDriveState>(status.state);
  state.ready = status.ready;
  state.enabled = status.enabled;
  state.error = status.error;
  state.command_path_alive =
      status.communication_ok && heartbeat_.alive(t, from_seconds(config_.heartbeat_echo_within_s));
  state.homed = status.homed;
  state.at_lower_limit = reversed ? status.at_max : status.at_min;
  state.at_upper_limit = reversed ? status.at_min : status.at_max;
  state.wire_length_m = to_wire(status.position_m);
  state.wire_speed_mps = config_.pay_out_sign * status.velocity_mps;
  state.wire_length_set_m = to_wire(status.set_position_m);
  state.wire_length_min_m = std::min(a_m, b_m);
  state.wire_length_max_m = std::max(a_m, b_m);
  state.motor_torque_nm = status.torque_nm;
  state.motor_temperature_degc = status.motor_temperature_degc;
  state.axis_error_id = status.axis_error_id;
  state.drive_diagnosis = status.drive_diagnosis;
  state.watchdog_trips = status.watchdog_trips;
  if (sink_) sink_(state);
}

}  // namespace motionlab::winch
