#include "gateway/service/controller_program/seat.hpp"

#include <signal.h>

#include <chrono>
#include <ctime>
#include <optional>

#include "gateway/service/log/log.hpp"
#include "gateway/service/real_time.hpp"

namespace motionlab::service {
namespace {

constexpr int kPriority = 60;              // of the control thread, under SCHED_FIFO
constexpr Nanoseconds kAsk = 500ms;        // from request to request, until one is obeyed
constexpr Nanoseconds kModeSilent = 3s;    // a gateway that lives tells its mode each second
constexpr Nanoseconds kStopPatience = 8s;  // for arm and winch to come to rest

sigset_t block_signals() {
  sigset_t signals;
  sigemptyset(&signals);
  for (const int signal : {SIGINT, SIGTERM}) sigaddset(&signals, signal);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  return signals;
}

void tell_refused(const std::string& sentence) {
  if (!sentence.empty()) say(LogLevel::warning, "controller", "kernel_refused", sentence);
}

}  // namespace

Seat::Seat(const GatewayConfig& config, const Text<32>& name)
    : config_(config),
      name_(name),
      dds_(config.bus, local_),
      controller_(config, local_, name),
      modes_(local_.reader<topic::Mode>()),
      requests_(local_.advertise<topic::ModeRequest>()) {
  dds_.in<topic::Mru>();
  dds_.in<topic::Bodies>();
  dds_.in<topic::ArmState>();
  dds_.in<topic::WinchState>();
  dds_.in<topic::Reference>();
  dds_.in<topic::Mode>();
  dds_.both<topic::ArmCommand>();
  dds_.both<topic::WinchCommand>();
  dds_.out<topic::ModeRequest>();
}

void Seat::control(std::stop_token stop) {
  tell_refused(become_real_time("control", kPriority, config_.control_cpu));
  Metronome metronome(from_seconds(config_.control_period_s));
  while (!stop.stop_requested()) {
    (void)metronome.wait();
    commands_.store(controller_.step(clock_.now()), std::memory_order_relaxed);
  }
}

bool Seat::run(bool engage) {
  const sigset_t signals = block_signals();
  tell_refused(lock_memory());
  leave_processor(config_.control_cpu);
  std::optional<AwakeProcessor> awake;
  if (config_.control_awake) tell_refused(awake.emplace(config_.control_cpu).refused());
  dds_.start();
  const std::jthread thread([this](std::stop_token stop) { control(std::move(stop)); });
  say(LogLevel::info, "controller", "running",
      "commands as " + name_.str() + (engage ? ", and asks to be engaged" : ", and asks for nothing"));
  for (;;) {
    constexpr timespec kPoll{0, 50'000'000};
    if (sigtimedwait(&signals, nullptr, &kPoll) > 0) break;
    const LabTime now = clock_.now();
    clock_.discipline();
    if (look(now) == State::lost) return false;
    if (engage && state_ == State::waiting) ask_to_be_engaged(now);
  }
  settle();
  return true;
}

Seat::State Seat::look(LabTime now) {
  if (modes_.newer()) mode_heard_ = now;
  const auto mode = modes_.newest();
  if (!mode) return state_;
  const bool owns = mode->state == topic::ModeState::engaged && mode->owner == name_;
  if (state_ == State::waiting && owns) {
    state_ = State::owning;
    say(LogLevel::info, "controller", "engaged", "owns the crane");
  } else if (state_ == State::owning && !owns) {
    state_ = State::lost;
    say(LogLevel::error, "controller", "let_go", "let go by the gateway: " + mode->reason.str());
  } else if (state_ == State::owning && now - mode_heard_ > kModeSilent) {
    state_ = State::lost;
    say(LogLevel::error, "controller", "gateway_silent",
        "the gateway has fallen silent: is its host up, and the network?");
  }
  return state_;
}

void Seat::ask(topic::ModeAction action) {
  topic::ModeRequest request;
  request.requester = name_;
  request.sequence_number = ++asked_;
  request.t_created_ns = to_ns(clock_.now());
  request.action = action;
  request.external_controller = true;
  requests_.publish(request);
}

void Seat::ask_to_be_engaged(LabTime now) {
  const auto mode = modes_.newest();
  std::string obstacle;
  if (!mode) {
    obstacle = "not heard";
  } else if (mode->state != topic::ModeState::ready) {
    obstacle = std::string{to_string(mode->state)} + ": " + mode->reason.str();
  } else if (!commands_.load(std::memory_order_relaxed)) {
    obstacle = "ready, but too little is heard of the laboratory to know what to do";
  }
  if (!obstacle.empty() && obstacle != obstacle_told_) {
    say(LogLevel::info, "controller", "waiting", "not engaged yet, the gateway is " + obstacle);
  }
  obstacle_told_ = obstacle;
  if (!obstacle.empty() || now < next_ask_) return;
  next_ask_ = now + kAsk;
  ask(topic::ModeAction::engage);
}

void Seat::settle() {
  const LabTime end = clock_.now() + kStopPatience;
  const auto moving = [this] {
    const auto mode = modes_.newest();
    return mode && mode->owner == name_ &&
           (mode->state == topic::ModeState::engaged || mode->state == topic::ModeState::stopping);
  };
  for (; moving() && clock_.now() < end; std::this_thread::sleep_for(50ms)) ask(topic::ModeAction::settle);
  say(LogLevel::info, "controller", "ended", moving() ? "ended, and the crane is not yet at rest" : "ended");
}

}  // namespace motionlab::service
