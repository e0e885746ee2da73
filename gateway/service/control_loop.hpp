/// @file  The control room: one step from the newest samples to the guarded command.
#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "drivers/core/time.hpp"
#include "gateway/bus/local_bus.hpp"
#include "gateway/controller/guard.hpp"
#include "gateway/controller/keeper.hpp"
#include "gateway/controller/mode_machine.hpp"
#include "gateway/estimator/lab_estimator.hpp"
#include "gateway/service/devices.hpp"
#include "gateway/service/gateway_config.hpp"
#include "gateway/service/readiness.hpp"
#include "gateway/service/snapshot.hpp"
#include "gateway/service/time_keeper.hpp"

namespace motionlab::service {

/// snapshot → estimate → control → guard → command, on the bus.
///
/// The same object runs on the control thread in real time and in lockstep. A step never allocates, locks,
/// logs or does I/O; it takes time as a parameter and knows no device but by its samples.
class ControlLoop {
 public:
  /// @param stopwatch  nanoseconds of a running clock, only to tell how long a step took; nothing in lockstep
  /// @param processor_time  nanoseconds that the calling thread has computed, likewise
  ControlLoop(const GatewayConfig& config, bus::LocalBus& local, ArmSchedule& schedule,
              std::function<std::int64_t()> stopwatch = {},
              std::function<std::int64_t()> processor_time = {});

  void step(LabTime t);

  [[nodiscard]] topic::ModeState mode() const { return modes_.state(); }
  /// Where the thread that steps this tells how it was woken.
  [[nodiscard]] TimeKeeper& time_keeper() { return time_keeper_; }

 private:
  void take_requests(LabTime t);
  /// Where the load shall be now. A moving place goes on for a moment, then stands.
  [[nodiscard]] controller::LoadReference reference_at(LabTime t) const;
  /// Whose own commands are taken up: the external owner's, or of one who asks to be engaged.
  [[nodiscard]] Text<32> external_controller() const;
  [[nodiscard]] std::optional<controller::Wish> wish(const Snapshot& snapshot,
                                                     const topic::Estimate& estimate);
  [[nodiscard]] controller::GuardedCommand guard(const Snapshot& snapshot,
                                                 const std::optional<controller::Wish>& wish, double dt_s);
  /// How much of the horizontal motion is compensated while nobody sees the load.
  void coast(const Snapshot& snapshot);
  void command(const Snapshot& snapshot, const controller::GuardedCommand& guarded);
  void tell_mode(LabTime t);
  void tell_time(LabTime t);

  GatewayConfig config_;
  Snapshots snapshots_;
  ArmSchedule& schedule_;
  std::function<std::int64_t()> stopwatch_, processor_time_;

  estimator::LabEstimator estimator_;
  std::unique_ptr<controller::Keeper> keeper_;
  controller::Guard guard_;
  estimator::MruMount mount_;
  Readiness readiness_;
  controller::ModeMachine modes_;
  controller::LoadReference reference_;
  std::optional<LabTime> reference_moved_;  ///< when a moving reference was last told

  bus::Subscription<topic::ModeRequest> requests_;
  bus::Subscription<topic::Reference> references_;
  bus::Publisher<topic::Estimate> publish_estimate_;
  bus::Publisher<topic::Control> publish_control_;
  bus::Publisher<topic::ArmCommand> publish_arm_;
  bus::Publisher<topic::WinchCommand> publish_winch_;
  bus::Publisher<topic::Mode> publish_mode_;
  bus::Publisher<topic::Event> publish_event_;
  bus::Publisher<topic::Health> publish_health_;
  bus::Publisher<topic::Timing> publish_timing_;
  TimeKeeper time_keeper_;

  std::optional<LabTime> stepped_;
  std::optional<LabTime> commanded_;  ///< when whoever is engaged last gave a wish
  double horizontal_share_ = 1.0;
  bool wish_missing_ = false;
  std::uint64_t steps_ = 0;
  std::uint64_t mode_told_ = 0;
  std::uint64_t events_ = 0;
  std::uint64_t healths_ = 0;
  std::uint64_t timings_ = 0;
};

}  // namespace motionlab::service
