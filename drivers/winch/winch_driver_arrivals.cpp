#include "drivers/winch/winch_driver.hpp"
#include "drivers/winch/winch_driver_advice.hpp"
#include "drivers/winch/winch_driver_status.hpp"

namespace motionlab::winch {

namespace {

constexpr Nanoseconds kDeletePeriod = 100ms;
constexpr Nanoseconds kEchoPatience = 1s;

constexpr Fault kNotOurs{Reason::foreign, "ADS frame that is not from the winch PLC, or not for us"};
constexpr Fault kBounced{Reason::unexpected,
                         "a router sent our own request back: check the route on the controller"};
constexpr Fault kUnasked{Reason::unexpected, "ADS answer to no open request (late, or not ours)"};
constexpr Fault kUnknownNotification{Reason::unexpected,
                                     "notification of a handle that is not ours; deleting it"};
constexpr Fault kOddSample{Reason::bad_header, "notification sample of another size than subscribed"};
constexpr Fault kAnswerError{Reason::refused, "the winch controller answered with an ADS error"};

}  // namespace

void WinchDriver::on_bytes(Bytes bytes, LabTime t_received) {
  now_ = t_received;
  splitter_.append(bytes);
  while (stage_ == Stage::setting_up || stage_ == Stage::running) {
    const auto next = splitter_.next();
    if (!next) {
      health_.rejected(next.fault());
      lose_link(advice::kMalformed, t_received);
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
      lose_link(advice::kMalformed, t_received);
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
  const auto resolved = counters_.resolved_again;
  while (const auto item = samples.next()) {
    take_sample(item->sample, t);
    const bool talking = stage_ == Stage::running || stage_ == Stage::setting_up;
    if (!talking || counters_.resolved_again != resolved) return;
  }
}

void WinchDriver::take_sample(const NotificationSample& sample, LabTime t) {
  const bool during_set_up = stage_ == Stage::setting_up;  // subscriptions are being made or given up
  if (!during_set_up && sample.handle == status_notification_) {
    if (sample.data.empty()) {
      resolve_again();
    } else if (sample.data.size() == kStatusSize) {
      take_status(sample.data, t);
    } else {
      health_.rejected(kOddSample);
    }
  } else if (sample.handle == version_notification_ && (!during_set_up || step_ == Step::subscribe_status)) {
    take_version(sample.data);
  } else if (!during_set_up) {
    take_foreign(sample.handle);
  }
}

void WinchDriver::take_version(Bytes data) {
  if (data.size() != 1) {
    health_.rejected(kOddSample);
    return;
  }
  const std::uint8_t version = data[0];
  const bool changed = symbol_version_ && *symbol_version_ != version;
  symbol_version_ = version;
  if (changed) resolve_again();
}

/// A subscription that a former life of ours left behind.
void WinchDriver::take_foreign(std::uint32_t handle) {
  ++counters_.foreign_notifications;
  health_.rejected(kUnknownNotification);
  if (now_ < next_delete_) return;
  next_delete_ = now_ + kDeletePeriod;
  request(Purpose::clean_up, AdsCommand::delete_notification, DeleteNotificationRequest{handle});
}

void WinchDriver::take_answer(const AmsFrame& frame, LabTime t) {
  const auto asked = requests_.close(frame.header);
  if (!asked) {
    health_.rejected(kUnasked);
    return;
  }
  timeouts_in_a_row_ = 0;
  round_trip_.add(t - asked->t_sent);
  if (asked->purpose == Purpose::write_command) commands_refused_ = false;
  if (frame.header.error != ads_error::none) {
    take_error(ErrorLevel::router, frame.header.error, asked->purpose, asked->command);
    return;
  }
  switch (asked->purpose) {
    case Purpose::none:
    case Purpose::clean_up:  // a handle that is gone already is as good as deleted
      break;
    case Purpose::set_up:
      take_step(frame);
      break;
    case Purpose::write_command:
      take_written(frame, *asked);
      break;
    case Purpose::read_status:
      take_read(frame, *asked, t);
      break;
  }
}

void WinchDriver::take_written(const AmsFrame& frame, const Request& asked) {
  if (config_.legacy()) {
    const auto answer = ReadResponse::decode(frame.data);
    if (!answer) {
      health_.rejected(answer.fault());
    } else if (answer->result != ads_error::none) {
      take_error(ErrorLevel::device, answer->result, asked.purpose, asked.command);
    } else {
      take_legacy_written(answer->data);
    }
    return;
  }
  const auto answer = ResultResponse::decode(frame.data);
  if (!answer) {
    health_.rejected(answer.fault());
  } else if (answer->result != ads_error::none) {
    take_error(ErrorLevel::device, answer->result, asked.purpose, asked.command);
  }
}

void WinchDriver::take_read(const AmsFrame& frame, const Request& asked, LabTime t) {
  const auto answer = ReadResponse::decode(frame.data);
  if (!answer) {
    health_.rejected(answer.fault());
  } else if (answer->result != ads_error::none) {
    take_error(ErrorLevel::device, answer->result, asked.purpose, asked.command);
  } else if (stage_ == Stage::running) {
    if (config_.legacy()) {
      take_legacy_status(answer->data, asked, t);
    } else {
      take_status(answer->data, t);
    }
  }
}

void WinchDriver::take_error(ErrorLevel level, std::uint32_t code, Purpose purpose, AdsCommand command) {
  health_.rejected(kAnswerError);
  if (errors_.note(level, code, command, now_)) advice_error_ = to_sentence(*errors_.newest());
  if (purpose == Purpose::clean_up) return;
  if (purpose == Purpose::write_command) commands_refused_ = true;
  switch (describe(code).error_class) {
    case ErrorClass::layout:
      halt({Reason::bad_header, "the PLC says that a size is wrong"});
      return;
    case ErrorClass::resolve_again:
    case ErrorClass::subscribe_again:
      if (stage_ == Stage::running || !t_resolved_again_) {
        resolve_again();
      } else {
        lose_link(advice_error_, now_);
      }
      return;
    case ErrorClass::offline:
      lose_link(advice::kPortNotFound, now_);
      return;
    case ErrorClass::not_running:
      lose_link(advice::kNotRun, now_);
      return;
    case ErrorClass::configuration:
      lose_link(code == ads_error::machine_not_found ? advice_net_id_ : advice_error_, now_);
      return;
    case ErrorClass::wrong_project:
      lose_link(config_.legacy() ? advice::kLacksLegacy : advice::kWrongProject, now_);
      return;
    case ErrorClass::none:
    case ErrorClass::back_off:
    case ErrorClass::retry:
    case ErrorClass::programming:
    case ErrorClass::leak:
    case ErrorClass::timeout:
    case ErrorClass::unknown:
      health_.advice(advice_error_);
      if (purpose == Purpose::set_up) retry_set_up(advice_error_);
      return;
  }
}

void WinchDriver::take_status(Bytes bytes, LabTime t) {
  const auto decoded = PlcStatus::decode(bytes);
  if (decoded) {
    accept(*decoded, t);
  } else if (decoded.fault().reason == Reason::bad_header) {
    halt(decoded.fault());
  } else {
    health_.rejected(decoded.fault());
  }
}

void WinchDriver::accept(const PlcStatus& status, LabTime t) {
  if (status_ && status.cycle_count == status_->cycle_count) {
    ++counters_.status_repeated;
    return;
  }
  const auto period_ns = from_seconds(config_.status_period_s).count();
  const auto gap_ns = status_ ? (status.t_plc - status_->t_plc).count() : 0;
  if (health_.phase() == LinkPhase::up && gap_ns > period_ns + period_ns / 2) {
    health_.lost(static_cast<std::uint64_t>((gap_ns + period_ns / 2) / period_ns - 1));
  }
  if (gap_ns < 0) clock_.reset();  // the PLC's clock was set back
  status_ = status;
  t_fresh_ = t;
  backoff_.reset();
  health_.phase(LinkPhase::up);
  heartbeat_.echoed(status.heartbeat_echo);
  arming_.heard(status, t);
  advise(status);
  tell(status, t);
}

/// The cause before its consequence: a PLC that refuses our commands also loses our heartbeat.
void WinchDriver::advise(const PlcStatus& status) {
  if (commands_refused_) {
    health_.advice(advice_error_);
  } else if (status.state == PlcState::communication_lost) {
    health_.advice(advice::kWatchdog);
  } else if (status.state == PlcState::fault || status.error) {
    const auto code = status.drive_diagnosis != 0 ? status.drive_diagnosis : status.axis_error_id;
    if (errors_.note(ErrorLevel::drive, code, {}, now_)) advice_error_ = to_sentence(*errors_.newest());
    health_.advice(advice_error_);
  } else if (!config_.commands()) {
    health_.advice(advice::kReadOnly);
  } else if (counters_.commands_written > 0 && !heartbeat_.alive(now_, kEchoPatience) &&
             now_ - t_opened_ > kEchoPatience) {
    health_.advice(advice::kCommandPath);
  } else {
    health_.advice({});
  }
}

void WinchDriver::tell(const PlcStatus& status, LabTime t) {
  const LabTime t_measured = config_.legacy() ? LabTime{status.t_plc} : clock_.map(status.t_plc, t);
  health_.accepted(t_measured, t);
  topic::WinchState state = to_state(status, axis_);
  state.device = config_.device;
  state.sequence_number = ++told_;
  state.t_measured_ns = to_ns(t_measured);
  state.t_received_ns = to_ns(t);
  state.command_path_alive =
      status.communication_ok && heartbeat_.alive(t, from_seconds(config_.heartbeat_echo_within_s));
  if (sink_) sink_(state);
}

}  // namespace motionlab::winch
