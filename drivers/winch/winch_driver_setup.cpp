#include "drivers/winch/winch_driver.hpp"
#include "drivers/winch/winch_driver_advice.hpp"

namespace motionlab::winch {

namespace {

constexpr Nanoseconds kResolveOncePer = 1s;
constexpr std::uint32_t kEntryMax = 4096;

}  // namespace

/// One request at a time, each after the answer to the one before.
void WinchDriver::send_step() {
  step_due_ = false;
  const auto set_up = [&](AdsCommand command, const auto& message, std::uint16_t port = 0) {
    request(Purpose::set_up, command, message, port);
  };
  const auto ask_name = [&](std::uint32_t group, std::uint32_t length, std::string_view symbol) {
    set_up(AdsCommand::read_write, ReadWriteRequest{group, 0, length, as_bytes(symbol)});
  };
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
      ask_name(index_group::handle_by_name, sizeof(command_handle_), config_.command_symbol);
      break;
    case Step::status_handle:
      ask_name(index_group::handle_by_name, sizeof(status_handle_), config_.status_symbol);
      break;
    case Step::first_status:
      set_up(AdsCommand::read, ReadRequest{index_group::value_by_handle, status_handle_, kStatusSize});
      break;
    case Step::legacy_handles:
      ask_legacy_handles();
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

WinchDriver::Step WinchDriver::next_step() const noexcept {
  switch (step_) {
    case Step::device_info:
      return config_.legacy() ? Step::legacy_handles : Step::command_symbol;
    case Step::first_status:
      return Step::subscribe_version;
    case Step::subscribe_version:
      return config_.legacy() ? Step::done : Step::subscribe_status;
    default:
      return static_cast<Step>(static_cast<std::uint8_t>(step_) + 1);
  }
}

/// Stays connected and asks from the beginning after a while.
void WinchDriver::retry_set_up(std::string_view advice) {
  health_.advice(advice);
  stage_ = Stage::setting_up;
  step_ = Step::system_state;
  step_due_ = true;
  retry_at_ = now_ + backoff_.next();
}

template <class Response>
bool WinchDriver::answered(const Response& response, const AmsFrame& frame) {
  if (!response) {
    health_.rejected(response.fault());
    lose_link(advice::kMalformed, now_);
    return false;
  }
  if (response->result == ads_error::none) return true;
  take_error(ErrorLevel::device, response->result, Purpose::set_up,
             static_cast<AdsCommand>(frame.header.command));
  return false;
}

void WinchDriver::take_step(const AmsFrame& frame) {
  switch (step_) {
    case Step::system_state:
    case Step::plc_state:
      if (!take_state(frame)) return;
      break;
    case Step::device_info: {
      const auto info = DeviceInfoResponse::decode(frame.data);
      if (!answered(info, frame)) return;
      device_info_ = *info;
      clean_up();  // what the connection before left outlives it
      break;
    }
    case Step::command_symbol:
    case Step::status_symbol:
      if (!take_symbol(frame)) return;
      break;
    case Step::command_handle:
    case Step::status_handle:
      if (!take_handle(frame)) return;
      break;
    case Step::first_status:
      if (!take_first_status(frame)) return;
      break;
    case Step::legacy_handles:
      if (!take_legacy_handles(frame)) return;
      break;
    case Step::subscribe_version:
    case Step::subscribe_status: {
      const auto answer = AddNotificationResponse::decode(frame.data);
      if (!answered(answer, frame)) return;
      (step_ == Step::subscribe_version ? version_notification_ : status_notification_) = answer->handle;
      break;
    }
    case Step::done:
      return;
  }
  step_ = next_step();
  if (step_ == Step::done) {
    start_running();
  } else {
    send_step();
  }
}

bool WinchDriver::take_state(const AmsFrame& frame) {
  const auto state = ReadStateResponse::decode(frame.data);
  if (!answered(state, frame)) return false;
  if (state->ads_state == AdsState::run) return true;
  retry_set_up(step_ == Step::system_state ? advice::kSystemNotRun : advice::kNotRun);
  return false;
}

bool WinchDriver::take_symbol(const AmsFrame& frame) {
  const auto answer = ReadResponse::decode(frame.data);
  if (!answered(answer, frame)) return false;
  const auto checked = step_ == Step::command_symbol ? check_symbol(answer->data, kCommandSize, kCommandType)
                                                     : check_symbol(answer->data, kStatusSize, kStatusType);
  if (!checked) halt(checked.fault());
  return checked.ok();
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

bool WinchDriver::take_handle(const AmsFrame& frame) {
  const auto answer = ReadResponse::decode(frame.data);
  if (!answered(answer, frame)) return false;
  if (answer->data.size() != sizeof(std::uint32_t)) {
    health_.rejected({Reason::bad_header, "a symbol handle has 4 bytes"});
    lose_link(advice::kMalformed, now_);
    return false;
  }
  const auto handle = load<std::uint32_t, std::endian::little>(answer->data);
  (step_ == Step::command_handle ? command_handle_ : status_handle_) = handle;
  return true;
}

bool WinchDriver::take_first_status(const AmsFrame& frame) {
  const auto answer = ReadResponse::decode(frame.data);
  if (!answered(answer, frame)) return false;
  const auto status = PlcStatus::decode(answer->data);
  if (!status && status.fault().reason != Reason::bad_value) {
    halt(status.fault());
    return false;
  }
  if (!status) {
    health_.rejected(status.fault());
    retry_set_up(advice::kStandsStill);
    return false;
  }
  // Only a reference: it may be as old as the PLC's last stop. What advances beyond it is told.
  status_ = *status;
  heartbeat_.restart(status->heartbeat_echo);
  arming_.heard(*status, now_);
  return true;
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
    lose_link(config_.legacy() ? advice::kLacksLegacy : advice::kWrongProject, now_);
    return;
  }
  t_resolved_again_ = now_;
  ++counters_.resolved_again;
  requests_.forget(Purpose::set_up);
  clean_up();
  symbol_version_.reset();
  stage_ = Stage::setting_up;
  step_ = config_.legacy() ? Step::legacy_handles : Step::command_symbol;
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
  for (auto* handle : {&command_handle_, &status_handle_}) {
    if (*handle == 0) continue;
    std::array<std::uint8_t, sizeof(*handle)> bytes{};
    store<std::endian::little>(bytes, *handle);
    request(Purpose::clean_up, AdsCommand::write, WriteRequest{index_group::release_handle, 0, bytes});
    *handle = 0;
  }
  release_legacy_handles();
}

}  // namespace motionlab::winch
