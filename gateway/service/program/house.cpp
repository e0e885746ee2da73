#include "gateway/service/program/house.hpp"

#include <signal.h>

#include <ctime>
#include <utility>
#include <vector>

#include "drivers/core/error.hpp"
#include "gateway/service/log/log.hpp"
#include "gateway/service/wiring.hpp"

namespace motionlab::service {
namespace {

/// How long arm and winch may take to come to rest at the end.
constexpr Nanoseconds kStopPatience = 8s;
/// How often the status is told.
constexpr Nanoseconds kLook = 1s;
/// While a device is waited for: systemd shall not give up before the next look, however late that comes.
constexpr Nanoseconds kWaitPatience = 30s;
/// Strokes within the time that the watchdog allows.
constexpr int kStrokes = 4;

/// Blocks the signals of the house for this thread and all that it starts, so that they can be waited for.
sigset_t block_signals() {
  sigset_t signals;
  sigemptyset(&signals);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&signals, signal);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  return signals;
}

void log_event(const topic::Event& event) {
  const auto level = event.severity == topic::Severity::info      ? LogLevel::info
                     : event.severity == topic::Severity::warning ? LogLevel::warning
                                                                  : LogLevel::error;
  say(level, event.source.view(), event.code.view(),
      event.source.str() + ' ' + event.code.str() + ": " + event.text.str());
}

}  // namespace

House::House(const GatewayConfig& config, std::function<GatewayConfig()> read_again,
             deadman::Lifeline& lifeline)
    : read_again_(std::move(read_again)), settings_(config), gateway_(config, clock_, lifeline) {}

void House::run() {
  const sigset_t signals = block_signals();
  set_log_level(settings_.in_force().log_level);
  for (const auto& note : settings_.in_force().notes) say(LogLevel::warning, "house", "note", note);
  for (const auto& refused : gateway_.start()) say(LogLevel::warning, "house", "kernel_refused", refused);
  say(LogLevel::info, "house", "running", "running\n" + wiring(settings_.in_force()));
  if (const auto file = gateway_.recording())
    say(LogLevel::info, "house", "recording", "recording to " + file->string());

  LabTime next_look = clock_.now();
  for (;;) {
    constexpr timespec kPoll{0, 100'000'000};
    const int signal = sigtimedwait(&signals, nullptr, &kPoll);
    if (signal == SIGHUP) reload();
    if (signal == SIGINT || signal == SIGTERM) break;
    gateway_.drain_events(log_event);
    look_at_links();
    look_at_threads(clock_.now());
    look_at_deadman_and_recording();
    if (ready_ && clock_.now() < next_look) continue;
    tell_status();
    if (clock_.now() < next_look) continue;
    next_look = clock_.now() + kLook;
    clock_.discipline();
  }
  settle();
}

void House::look_at_links() {
  gateway_.for_each_health([this](const topic::Health& health) {
    const std::string link{to_string(health.link)};
    const std::string now = health.advice.empty() ? link : link + ": " + health.advice.str();
    std::string& told = link_told_[health.device.str()];
    if (now == told) return;
    told = now;
    const bool fine = health.link == topic::LinkState::up && health.advice.empty();
    say(fine ? LogLevel::info : LogLevel::warning, health.device.view(), "link_" + link,
        health.device.str() + ' ' + now);
  });
}

void House::look_at_threads(LabTime now) {
  if (manager_.watchdog() == Nanoseconds{0} || now < next_stroke_) return;
  if (rounds_.all_came_round(gateway_.rounds())) {
    manager_.stroke();
    next_stroke_ = now + manager_.watchdog() / kStrokes;
    silent_told_.clear();
  } else if (silent_told_ != rounds_.silent()) {
    silent_told_ = rounds_.silent();
    say(LogLevel::error, "house", "thread_silent",
        "no answer from thread " + silent_told_ + "; if it stays so, systemd kills and restarts the gateway");
  }
}

void House::look_at_deadman_and_recording() {
  if (gateway_.deadman_lost() && !std::exchange(deadman_lost_told_, true)) {
    say(LogLevel::error, "house", "deadman_lost",
        "the deadman process is gone or stands still: nothing may move until the gateway is restarted");
  }
  if (const auto trouble = gateway_.recording_trouble(); trouble && *trouble != recording_trouble_told_) {
    recording_trouble_told_ = *trouble;
    say(LogLevel::error, "house", "recording_trouble", *trouble);
  }
}

void House::tell_status() {
  std::vector<topic::Health> healths;
  gateway_.for_each_health([&healths](const topic::Health& health) { healths.push_back(health); });
  const RollCall roll = call_roll(settings_.in_force(), healths);
  const std::string sentence = roll.sentence(gateway_.mode()) + reload_note_;
  if (ready_) {
    manager_.status(sentence);
  } else if (roll.complete()) {
    ready_ = true;
    manager_.status(sentence);
    manager_.ready();
    say(LogLevel::info, "house", "ready", "every required device is connected or declared absent");
  } else {
    manager_.waiting(sentence, kWaitPatience);
    if (waiting_told_ != roll.waited_for()) {
      waiting_told_ = roll.waited_for();
      say(LogLevel::info, "house", "waiting", "waiting for " + waiting_told_);
    }
  }
}

void House::reload() {
  if (ready_) manager_.reloading();
  reload_note_.clear();
  try {
    const GatewayConfig read = read_again_();
    const auto reference = settings_.in_force().p_world_load_reference_m;
    const auto changes = settings_.take(read, gateway_.mode().state);
    set_log_level(settings_.in_force().log_level);
    if (settings_.in_force().p_world_load_reference_m != reference) {
      gateway_.set_reference(settings_.in_force().p_world_load_reference_m);
    }
    for (const auto& change : changes) {
      if (change.refused.empty()) {
        say(LogLevel::info, "house", "reload_taken", change.key + " is taken");
      } else {
        say(LogLevel::warning, "house", "reload_refused", change.key + " stays as it was: " + change.refused);
        reload_note_ += (reload_note_.empty() ? "; reload refused " : ", ") + change.key;
      }
    }
    if (changes.empty()) say(LogLevel::info, "house", "reload_taken", "the configuration has not changed");
  } catch (const StartupError& error) {
    say(LogLevel::error, "house", "reload_refused", std::string("nothing is taken: ") + error.what());
    reload_note_ = "; reload refused: the configuration has an error";
  }
  if (ready_) manager_.ready();
}

void House::settle() {
  manager_.stopping();
  say(LogLevel::info, "house", "settling", "settling");
  const bool at_rest = gateway_.stop(kStopPatience);
  gateway_.drain_events(log_event);
  if (at_rest) {
    say(LogLevel::info, "house", "at_rest",
        "arm and winch were told to rest; " + std::to_string(gateway_.missed_beats()) +
            " control periods were missed");
  } else {
    say(LogLevel::warning, "house", "not_at_rest",
        "a device did not come to rest or did not answer; look at the arm before you go near it");
  }
}

}  // namespace motionlab::service
