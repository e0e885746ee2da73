/// @file  `RemoteController`: the controller of the house on another host than the drivers.
#pragma once

#include <cstdint>
#include <optional>

#include "drivers/core/text.hpp"
#include "drivers/core/time.hpp"
#include "gateway/bus/local_bus.hpp"
#include "gateway/service/gateway_config.hpp"
#include "gateway/service/own_controller.hpp"
#include "gateway/service/readiness.hpp"
#include "gateway/service/snapshot.hpp"
#include "idl/topics.hpp"

namespace motionlab::service {

/// Estimates from what a gateway elsewhere publishes, and commands as an external controller of it. That
/// gateway's modes, guard and deadman have the last word, as with anybody's controller.
///
/// It commands in every step in which it knows what to do, rest while it does not own the crane, so that it
/// can be engaged; silent otherwise, which ends its lease. Samples, commands and lease compare the clocks of
/// both hosts: they must be disciplined. One thread; a step never allocates, locks, logs or does I/O.
class RemoteController {
 public:
  /// @param local  carries both ways what DdsBus carries between the hosts; outlives this
  /// @param name  as which it commands; whoever asks to be engaged asks under this name
  RemoteController(const GatewayConfig& config, bus::LocalBus& local, const Text<32>& name);

  /// @returns whether it commanded
  bool step(LabTime t);

 private:
  [[nodiscard]] bool owns_the_crane() const;
  /// The gateway's command is what left for the arm, as far as it is known here.
  void hear_what_left();
  void command(LabTime t, const controller::Wish& wish);

  GatewayConfig config_;
  Text<32> name_;
  ArmSchedule schedule_;
  Inputs inputs_;
  Newest newest_;
  OwnController own_;
  Readiness readiness_;
  bus::Reader<topic::Mode> mode_;
  bus::Reader<topic::ArmCommand> left_;
  bus::Publisher<topic::ArmCommand> arm_;
  bus::Publisher<topic::WinchCommand> winch_;
  std::optional<LabTime> stepped_;
  std::uint64_t steps_ = 0;
};

}  // namespace motionlab::service
