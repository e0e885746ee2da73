/// @file  The seat of a controller that is on another host than its gateway: threads, DDS, and who asks for
/// what.
#pragma once

#include <atomic>
#include <string>
#include <thread>

#include "drivers/core/real_clock.hpp"
#include "gateway/bus/dds_bus.hpp"
#include "gateway/bus/local_bus.hpp"
#include "gateway/service/remote_controller.hpp"

namespace motionlab::service {

/// Control on a thread of its own; the calling thread looks on and asks. Once it has owned the crane and lost
/// it, it is over: nothing engages a second time by itself.
class Seat {
 public:
  /// @throws StartupError  no DDS
  Seat(const GatewayConfig& config, const Text<32>& name);

  /// Runs until SIGINT or SIGTERM, then asks for rest; or until the gateway lets it go.
  /// @param engage  asks to be engaged as soon as the gateway would
  /// @returns whether it ended because it was asked to
  bool run(bool engage);

 private:
  enum class State { waiting, owning, lost };

  void control(std::stop_token stop);
  State look(LabTime now);
  void ask(topic::ModeAction action);
  /// When nothing is in the way; else says once what it is.
  void ask_to_be_engaged(LabTime now);
  void settle();

  GatewayConfig config_;
  Text<32> name_;
  RealClock clock_;
  bus::LocalBus local_;
  bus::DdsBus dds_;
  RemoteController controller_;
  bus::Reader<topic::Mode> modes_;
  bus::Publisher<topic::ModeRequest> requests_;
  std::atomic<bool> commands_{false};  ///< the controller knew what to do in its last step
  State state_ = State::waiting;
  std::uint64_t asked_ = 0;
  LabTime mode_heard_{}, next_ask_{};
  std::string obstacle_told_;
};

}  // namespace motionlab::service
