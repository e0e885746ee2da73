/// @file  The control room: one step from the newest samples to the guarded command.
#pragma once

#include <functional>
#include <optional>

#include "drivers/core/time.hpp"
#include "gateway/bus/local_bus.hpp"
#include "gateway/controller/guard.hpp"
#include "gateway/controller/mode_machine.hpp"
#include "gateway/record/run_tape.hpp"
#include "gateway/service/devices.hpp"
#include "gateway/service/gateway_config.hpp"
#include "gateway/service/own_controller.hpp"
#include "gateway/service/readiness.hpp"
#include "gateway/service/snapshot.hpp"
#include "gateway/service/time_keeper.hpp"

namespace motionlab::service {

/// Publishes on the bus, and on the tape where there is one.
template <class T>
class Out {
 public:
  Out(bus::LocalBus& local, record::RunTape* tape) : publisher_(local.advertise<T>()), tape_(tape) {}
  /// The first to publish an instance owns it: publishes, and tells the tape nothing.
  void claim(const T& sample) { publisher_.publish(sample); }
  void publish(const T& sample) {
    publisher_.publish(sample);
    if (tape_) tape_->add(sample);
  }

 private:
  bus::Publisher<T> publisher_;
  record::RunTape* tape_;
};

/// snapshot → estimate → control → guard → command, on the bus.
///
/// The same object runs on the control thread in real time and in lockstep. A step never allocates, locks,
/// logs or does I/O; it takes time as a parameter and knows no device but by its samples.
class ControlLoop {
 public:
  /// @param stopwatch  nanoseconds of a running clock, only to tell how long a step took; nothing in lockstep
  /// @param processor_time  nanoseconds that the calling thread has computed, likewise
  /// @param tape  is told every step's inputs and what it published; null: nobody is
  ControlLoop(const GatewayConfig& config, bus::LocalBus& local, ArmSchedule& schedule,
              std::function<std::int64_t()> stopwatch = {}, std::function<std::int64_t()> processor_time = {},
              record::RunTape* tape = nullptr);

  /// Gathers the inputs at time t and takes the step.
  void step(LabTime t);
  /// One step. Depends on these inputs, on those of the steps before and on the configuration, and on nothing
  /// else: the same give the same, to the bit (but for `step_time_us`).
  void step(const topic::Snapshot& inputs);

  [[nodiscard]] topic::ModeState mode() const { return modes_.state(); }
  /// Where the thread that steps this tells how it was woken.
  [[nodiscard]] TimeKeeper& time_keeper() { return time_keeper_; }

 private:
  /// Whose own commands are taken up: the external owner's, or of one who asks to be engaged.
  [[nodiscard]] Text<32> external_controller(const topic::Snapshot& inputs) const;
  [[nodiscard]] std::optional<controller::Wish> wish(const Snapshot& snapshot,
                                                     const topic::Estimate& estimate);
  [[nodiscard]] controller::GuardedCommand guard(const Snapshot& snapshot,
                                                 const std::optional<controller::Wish>& wish, double dt_s);
  void command(const Snapshot& snapshot, const controller::GuardedCommand& guarded);
  /// Of this step, all but how long it took.
  [[nodiscard]] topic::Control account(const Snapshot& snapshot, const std::optional<controller::Wish>& wish,
                                       const controller::GuardedCommand& guarded) const;
  void tell_mode(LabTime t);
  void tell_time(LabTime t);

  GatewayConfig config_;
  Inputs inputs_;
  Newest newest_;
  std::function<std::int64_t()> stopwatch_, processor_time_;
  record::RunTape* tape_;

  OwnController own_;
  controller::Guard guard_;
  estimator::MruMount mount_;
  Readiness readiness_;
  controller::ModeMachine modes_;

  Out<topic::Estimate> publish_estimate_;
  Out<topic::Control> publish_control_;
  Out<topic::ArmCommand> publish_arm_;
  Out<topic::WinchCommand> publish_winch_;
  Out<topic::Mode> publish_mode_;
  Out<topic::Event> publish_event_;
  bus::Publisher<topic::Health> publish_health_;
  bus::Publisher<topic::Timing> publish_timing_;
  TimeKeeper time_keeper_;

  std::optional<LabTime> stepped_;
  std::optional<LabTime> commanded_;  ///< when whoever is engaged last gave a wish
  bool wish_missing_ = false;
  std::uint64_t steps_ = 0;
  std::uint64_t mode_told_ = 0;
  std::uint64_t events_ = 0;
  std::uint64_t healths_ = 0;
  std::uint64_t timings_ = 0;
};

}  // namespace motionlab::service
