#include "drivers/winch/winch_driver.hpp"

#include <utility>

#include "drivers/winch/winch_driver_advice.hpp"

namespace motionlab::winch {

namespace {

constexpr std::size_t kBodyMax = 64 * 1024;  // nothing we ask for has a longer answer
constexpr std::uint32_t kTimeoutsMax = 3;
constexpr Fault kTimedOut{Reason::transport, "the winch controller did not answer a request in time"};

}  // namespace

WinchDriver::WinchDriver(DriverConfig config, StreamOut& out, Sink<topic::WinchState> sink)
    : config_(std::move(config)),
      axis_(config_.axis()),
      out_(out),
      sink_(std::move(sink)),
      clock_({.latency = from_seconds(config_.latency_s)}),
      splitter_(kBodyMax),
      advice_route_(
          "AMS router: winch controller closed the connection at our first request: it has no route to "
          "NetId " +
          to_string(config_.local.net_id) + "; add one in TwinCAT"),
      advice_net_id_("AMS router: winch controller does not know the AMS NetId " +
                     to_string(config_.target.net_id) + " (AMS error 7): correct the target NetId"),
      backoff_(config_.reconnect_min_s, config_.reconnect_max_s, config_.jitter_seed),
      commands_(axis_, from_seconds(config_.command_stale_after_s)) {}

Status WinchDriver::set_command(const topic::WinchCommand& command) {
  const Status taken = commands_.set(command, config_.device, now_);
  if (!taken) {
    health_.rejected(taken.fault());
    return taken;
  }
  const bool in_touch = stage_ == Stage::running && health_.phase() == LinkPhase::up;
  arming_.wish(command.enable, command.reset, in_touch, now_);
  return Done{};
}

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
      if (now - t_opened_ >= from_seconds(config_.connect_timeout_s)) lose_link(advice::kNoAnswer, now);
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
  requests_.clear();
  timeouts_in_a_row_ = 0;
  heard_anything_ = false;
  commands_refused_ = false;
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
  lose_link(stage_ == Stage::opening ? advice::kRefused
            : heard_anything_        ? advice::kBroken
                                     : std::string_view{advice_route_},
            t);
}

void WinchDriver::lose_link(std::string_view advice, LabTime now) {
  out_.close();
  splitter_.reset();
  requests_.clear();
  status_.reset();
  arming_.disarm();
  health_.phase(LinkPhase::down);
  health_.advice(advice);
  if (stopping_ != Stopping::no) {  // the PLC's watchdog stops the winch; there is nobody left to talk to
    stage_ = Stage::ended;
    return;
  }
  stage_ = Stage::waiting;
  retry_at_ = now + backoff_.next();
}

void WinchDriver::halt(Fault fault) {
  health_.rejected(fault);
  health_.advice(advice::kLayout);
  arming_.disarm();
  finish();
  stage_ = Stage::halted;
}

void WinchDriver::finish() {
  out_.close();
  splitter_.reset();
  requests_.clear();
  health_.phase(LinkPhase::down);
  stage_ = Stage::ended;
}

void WinchDriver::check_timeouts() {
  bool repeat_step = false;
  while (const auto expired = requests_.expired(now_, from_seconds(config_.request_timeout_s))) {
    repeat_step = repeat_step || expired->purpose == Purpose::set_up;
    ++counters_.timeouts;
    ++timeouts_in_a_row_;
    health_.rejected(kTimedOut);
  }
  if (timeouts_in_a_row_ >= kTimeoutsMax) {
    lose_link(advice::kNoAnswer, now_);
  } else if (repeat_step) {
    step_due_ = true;
    retry_at_ = now_;
  }
}

}  // namespace motionlab::winch
