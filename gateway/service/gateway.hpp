/// @file  The gateway in real time: the threads, and who may touch what.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "drivers/core/time.hpp"
#include "gateway/deadman/page/lifeline.hpp"
#include "gateway/service/gateway_config.hpp"
#include "gateway/service/rounds.hpp"
#include "idl/event.hpp"
#include "idl/health.hpp"
#include "idl/mode.hpp"

namespace motionlab::service {

/// Runs the threads `io` (sockets, drivers), `control` (snapshot to guard), `bus` (DDS) and, where it is
/// asked for, the one that writes the recording, until told to stop. They share nothing but the local bus,
/// the arm's schedule and the tape of the recording, all free of locks.
class Gateway {
 public:
  /// Opens every socket and joins DDS. @throws StartupError before any thread runs
  /// @param lifeline  to the deadman, which was forked before; outlives this
  Gateway(const GatewayConfig& config, Clock& clock, deadman::Lifeline& lifeline);
  ~Gateway();
  Gateway(const Gateway&) = delete;
  Gateway& operator=(const Gateway&) = delete;

  /// Starts the threads. @returns what the kernel refused, one sentence each
  std::vector<std::string> start();

  /// Settles: brings arm and winch to rest on the wire, tells the robot computer to hold, then ends the
  /// threads. Gives up waiting for rest after `patience`. Lets the deadman go when all came to rest; else
  /// that one tries again once this process is gone. @returns whether all came to rest
  bool stop(Nanoseconds patience);

  /// Events since the last call, oldest first; for the house thread's log.
  void drain_events(const std::function<void(const topic::Event&)>& each);
  [[nodiscard]] topic::Mode mode() const;
  /// The newest health of every device.
  void for_each_health(const std::function<void(const topic::Health&)>& each) const;
  /// The file that the control thread's inputs are written to, if any.
  [[nodiscard]] std::optional<std::filesystem::path> recording() const;
  /// What is wrong with that file, as a sentence; nothing when all is well.
  [[nodiscard]] std::optional<std::string> recording_trouble() const;
  /// The deadman process is gone or stands still: there is no engaging any more until the gateway is
  /// restarted.
  [[nodiscard]] bool deadman_lost() const;
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
