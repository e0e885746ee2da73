/// @file  The gateway in real time: the threads, and who may touch what.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <string>

#include "drivers/core/time.hpp"
#include "gateway/service/gateway_config.hpp"
#include "gateway/service/rounds.hpp"
#include "idl/event.hpp"
#include "idl/health.hpp"
#include "idl/mode.hpp"

namespace motionlab::service {

/// Runs the threads `io` (sockets, drivers), `control` (snapshot to guard) and `bus` (DDS) until told to
/// stop. They share nothing but the local bus and the arm's schedule, both free of locks.
class Gateway {
 public:
  /// Opens every socket and joins DDS. @throws StartupError before any thread runs
  Gateway(const GatewayConfig& config, Clock& clock);
  ~Gateway();
  Gateway(const Gateway&) = delete;
  Gateway& operator=(const Gateway&) = delete;

  /// Starts the threads. @returns what the kernel refused, one sentence each
  std::vector<std::string> start();

  /// Settles: brings arm and winch to rest on the wire, tells the robot computer to hold, then ends the
  /// threads. Gives up waiting for rest after `patience`. @returns whether all came to rest
  bool stop(Nanoseconds patience);

  /// Events since the last call, oldest first; for the house thread's log.
  void drain_events(const std::function<void(const topic::Event&)>& each);
  [[nodiscard]] topic::Mode mode() const;
  /// The newest health of every device.
  void for_each_health(const std::function<void(const topic::Health&)>& each) const;
  /// Control periods that were slept through since the start.
  [[nodiscard]] std::uint64_t missed_beats() const;
  /// How often each thread has come round.
  [[nodiscard]] Rounds rounds() const;
  /// Where the load shall be from now on, as if somebody had told `motionlab/reference`.
  void set_reference(const std::array<double, 3>& p_world_load_m);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace motionlab::service
