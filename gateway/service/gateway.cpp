#include "gateway/service/gateway.hpp"

#include <fcntl.h>

#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <ctime>
#include <future>
#include <optional>
#include <thread>

#include "drivers/core/asio_network.hpp"
#include "gateway/bus/dds_bus.hpp"
#include "gateway/bus/local_bus.hpp"
#include "gateway/record/run_recorder.hpp"
#include "gateway/record/run_tape.hpp"
#include "gateway/service/control_loop.hpp"
#include "gateway/service/devices.hpp"
#include "gateway/service/real_time.hpp"

namespace motionlab::service {
namespace {

constexpr auto kDriverPeriod = std::chrono::milliseconds{1};
constexpr std::uint64_t kBeatsPerCountOfFaults = 100;
constexpr int kControlPriority = 80;
constexpr int kIoPriority = 70;
/// The tape holds seconds; it is emptied this often.
constexpr auto kRecordPeriod = std::chrono::milliseconds{50};

std::int64_t monotonic_ns() {
  return std::chrono::steady_clock::now().time_since_epoch().count();
}

std::int64_t thread_time_ns() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return std::int64_t{1'000'000'000} * time.tv_sec + time.tv_nsec;
}

}  // namespace

struct Gateway::Impl {
  Impl(const GatewayConfig& c, Clock& clock_in, deadman::Lifeline& lifeline_in)
      : config(c),
        clock(clock_in),
        lifeline(lifeline_in),
        network(io, clock),
        devices(c, network, local, schedule,
                [this](const topic::ArmCommand& sent) { lifeline.sent(sent.follow, sent.qd_wanted_radps); }),
        tape(c.record.inputs.empty() ? nullptr : std::make_unique<record::RunTape>(c.record.outputs_every)),
        control(c, local, schedule, monotonic_ns, thread_time_ns, tape.get()),
        events(local.subscribe<topic::Event>()),
        modes(local.reader<topic::Mode>()),
        requests(local.advertise<topic::ModeRequest>()),
        references(local.advertise<topic::Reference>()),
        dds(c.bus, local),
        driver_timer(io),
        deadman_end(io, ::fcntl(lifeline.deadman_pidfd(), F_DUPFD_CLOEXEC, 0)) {
    if (tape) {
      recorder.emplace(record::unused_name(c.record.inputs), *tape, c.effective, c.record.zstd_level);
    }
    dds.out<topic::Mru>();
    dds.out<topic::Bodies>();
    dds.out<topic::ArmState>();
    dds.both<topic::ArmCommand>();
    dds.out<topic::WinchState>();
    dds.both<topic::WinchCommand>();
    dds.out<topic::Estimate>();
    dds.out<topic::Control>();
    dds.out<topic::Mode>();
    dds.out<topic::Health>();
    dds.out<topic::Timing>();
    dds.out<topic::Event>();
    dds.in<topic::ModeRequest>();
    dds.in<topic::Reference>();
  }

  /// Steps the drivers each millisecond, and exactly when the arm's next command is due.
  void arm_driver_timer() {
    const LabTime now = clock.now();
    const auto until_send = std::chrono::duration_cast<std::chrono::nanoseconds>(devices.next_send() - now);
    const auto wait =
        until_send > 0ns && until_send < kDriverPeriod ? until_send : Nanoseconds{kDriverPeriod};
    driver_timer.expires_after(wait);
    driver_timer.async_wait([this](const boost::system::error_code& cancelled) {
      if (cancelled) return;
      devices.step(clock.now());
      lifeline.io_beat();
      if (lifeline.deadman_silent()) schedule.deadman_lost.store(true, std::memory_order_relaxed);
      io_rounds.fetch_add(1, std::memory_order_relaxed);
      arm_driver_timer();
    });
  }

  /// Hears of the deadman's death at once.
  void watch_deadman() {
    deadman_end.async_wait(boost::asio::posix::stream_descriptor::wait_read,
                           [this](const boost::system::error_code& cancelled) {
                             if (!cancelled) schedule.deadman_lost.store(true, std::memory_order_relaxed);
                           });
  }

  void run_control(std::promise<std::string> told) {
    told.set_value(become_real_time("control", kControlPriority, config.control_cpu));
    Metronome metronome(from_seconds(config.control_period_s));
    for (std::uint64_t beat = 0; !stopping.load(std::memory_order_relaxed); ++beat) {
      const auto woken = metronome.wait();
      missed.fetch_add(woken.missed, std::memory_order_relaxed);
      control.time_keeper().woke(woken.late, woken.missed);
      if (beat % kBeatsPerCountOfFaults == 0) control.time_keeper().page_faults(page_faults());
      control.step(clock.now());
      lifeline.control_beat();
      control_rounds.fetch_add(1, std::memory_order_relaxed);
    }
  }

  /// Writes down what the control thread left on the tape. Waits for nobody, nobody waits for it.
  void run_recorder() {
    while (!recorded.load(std::memory_order_acquire)) {
      std::this_thread::sleep_for(kRecordPeriod);
      (void)recorder->drain();
      if (recorder->trouble()) recorder_failed.store(true, std::memory_order_release);
    }
    recorder->finish();
    if (recorder->trouble()) recorder_failed.store(true, std::memory_order_release);
  }

  void run_io(std::promise<std::string> told) {
    told.set_value(become_real_time("io", kIoPriority, config.io_cpu));
    arm_driver_timer();
    watch_deadman();
    io.run();
  }

  /// Runs a thread function that first tells what the kernel refused it.
  std::string launch(std::thread& thread, void (Impl::*body)(std::promise<std::string>)) {
    std::promise<std::string> promise;
    auto refused = promise.get_future();
    thread = std::thread(body, this, std::move(promise));
    return refused.get();
  }

  /// Waits on the calling thread until `done` holds or patience ends.
  template <class Done>
  static bool wait_until(Done&& done, std::chrono::steady_clock::time_point end) {
    while (!done()) {
      if (std::chrono::steady_clock::now() >= end) return false;
      std::this_thread::sleep_for(std::chrono::milliseconds{2});
    }
    return true;
  }

  void ask(topic::ModeAction action) {
    topic::ModeRequest request;
    request.requester = "motionlab-gateway";
    request.t_created_ns = to_ns(clock.now());
    request.action = action;
    requests.publish(request);
  }

  GatewayConfig config;
  Clock& clock;
  deadman::Lifeline& lifeline;
  bus::LocalBus local;
  ArmSchedule schedule;
  boost::asio::io_context io{1};
  AsioNetwork network;
  Devices devices;
  std::unique_ptr<record::RunTape> tape;  ///< null: nothing is recorded
  ControlLoop control;
  bus::Subscription<topic::Event> events;
  bus::Reader<topic::Mode> modes;
  bus::Publisher<topic::ModeRequest> requests;
  bus::Publisher<topic::Reference> references;
  bus::DdsBus dds;
  boost::asio::steady_timer driver_timer;
  boost::asio::posix::stream_descriptor deadman_end;
  std::thread io_thread;
  std::thread control_thread;
  std::optional<AwakeProcessor> awake;
  std::optional<record::RunRecorder> recorder;
  std::thread record_thread;
  std::atomic<bool> recorded{false};  ///< the control thread has taken its last step
  std::atomic<bool> recorder_failed{false};
  std::atomic<bool> stopping{false};
  std::atomic<std::uint64_t> missed{0};
  std::atomic<std::uint64_t> io_rounds{0};
  std::atomic<std::uint64_t> control_rounds{0};
};

Gateway::Gateway(const GatewayConfig& config, Clock& clock, deadman::Lifeline& lifeline)
    : impl_(std::make_unique<Impl>(config, clock, lifeline)) {}

Gateway::~Gateway() {
  if (impl_->io_thread.joinable()) stop(0ns);
}

std::vector<std::string> Gateway::start() {
  std::vector<std::string> refused;
  const auto note = [&refused](std::string sentence) {
    if (!sentence.empty()) refused.push_back(std::move(sentence));
  };
  note(lock_memory());
  leave_processor(impl_->config.control_cpu);
  impl_->dds.start();
  if (impl_->recorder) impl_->record_thread = std::thread(&Impl::run_recorder, impl_.get());
  note(impl_->launch(impl_->io_thread, &Impl::run_io));
  note(impl_->launch(impl_->control_thread, &Impl::run_control));
  if (impl_->config.control_awake) note(impl_->awake.emplace(impl_->config.control_cpu).refused());
  return refused;
}

bool Gateway::stop(Nanoseconds patience) {
  Impl& g = *impl_;
  const auto end = std::chrono::steady_clock::now() + patience;
  g.ask(topic::ModeAction::settle);
  const bool settled = Impl::wait_until(
      [&] {
        const auto state = mode().state;
        return state != topic::ModeState::engaged && state != topic::ModeState::stopping;
      },
      end);
  // The devices belong to the io thread; ask it, and look again through it.
  std::atomic<bool> devices_stopped{false};
  boost::asio::post(g.io, [&g] { g.devices.orderly_stop(); });
  const bool stopped = Impl::wait_until(
      [&] {
        boost::asio::post(g.io, [&g, &devices_stopped] { devices_stopped.store(g.devices.stopped()); });
        return devices_stopped.load();
      },
      end);
  if (settled && stopped) {
    g.lifeline.end_in_order();
  } else {
    g.lifeline.leave();
  }
  g.stopping.store(true);
  g.control_thread.join();
  g.awake.reset();
  g.recorded.store(true, std::memory_order_release);
  if (g.record_thread.joinable()) g.record_thread.join();
  boost::asio::post(g.io, [&g] { g.io.stop(); });
  g.io_thread.join();
  g.dds.stop();
  return settled && stopped;
}

void Gateway::drain_events(const std::function<void(const topic::Event&)>& each) {
  while (const auto event = impl_->events.next()) each(*event);
}

topic::Mode Gateway::mode() const {
  return impl_->modes.newest().value_or(topic::Mode{});
}

void Gateway::for_each_health(const std::function<void(const topic::Health&)>& each) const {
  impl_->local.for_each_newest<topic::Health>(each);
}

std::optional<std::filesystem::path> Gateway::recording() const {
  if (!impl_->recorder) return std::nullopt;
  return impl_->recorder->file();
}

std::optional<std::string> Gateway::recording_trouble() const {
  if (!impl_->recorder) return std::nullopt;
  const auto& file = impl_->recorder->file();
  if (impl_->recorder_failed.load(std::memory_order_acquire)) return record::RunRecorder::full(file);
  if (impl_->tape->lost() > 0)
    return "the recording " + file.string() +
           " has gaps: its disk is too slow; record to another, or raise [record] outputs_every";
  return std::nullopt;
}

bool Gateway::deadman_lost() const {
  return impl_->schedule.deadman_lost.load(std::memory_order_relaxed);
}

std::uint64_t Gateway::missed_beats() const {
  return impl_->missed.load(std::memory_order_relaxed);
}

Rounds Gateway::rounds() const {
  return {impl_->io_rounds.load(std::memory_order_relaxed),
          impl_->control_rounds.load(std::memory_order_relaxed), impl_->dds.rounds()};
}

void Gateway::set_reference(const std::array<double, 3>& p_world_load_m) {
  topic::Reference reference;
  reference.t_created_ns = to_ns(impl_->clock.now());
  reference.p_world_load_m = p_world_load_m;
  impl_->references.publish(reference);
}

}  // namespace motionlab::service
