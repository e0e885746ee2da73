/// @file  The io room: every driver with its transport. What arrives is told to the bus, what is commanded
/// leaves.
#pragma once

#include <atomic>
#include <memory>
#include <vector>

#include "drivers/core/bounded_queue.hpp"
#include "drivers/core/network.hpp"
#include "drivers/core/sink.hpp"
#include "gateway/bus/local_bus.hpp"
#include "gateway/service/gateway_config.hpp"
#include "idl/topics.hpp"

namespace motionlab::service {

/// What the control thread has to know about the sending of commands. Written by io, read by control, without
/// a lock.
struct ArmSchedule {
  BoundedQueue<topic::ArmCommand, 64> sent;     ///< what really left, and when (`t_created_ns`)
  std::atomic<std::int64_t> t_next_send_ns{0};  ///< when the next command leaves
  std::atomic<bool> deadman_lost{false};        ///< nobody would brake the arm if this process died
};

/// All drivers, wired to transports of one network. One thread: the one that runs the network.
///
/// The same for real sockets and for the memory network; nothing here knows which.
class Devices {
 public:
  /// Opens every socket. @throws StartupError when one cannot be opened
  /// @param on_arm_sent  optional: every arm command that really left, at once
  Devices(const GatewayConfig& config, Network& network, bus::LocalBus& local, ArmSchedule& schedule,
          Sink<topic::ArmCommand> on_arm_sent = {});
  ~Devices();

  /// Runs the drivers' timers: call about every millisecond and at `next_send`. Publishes health ten times a
  /// second.
  void step(LabTime now);
  /// When the next arm command is due.
  [[nodiscard]] LabTime next_send() const;

  /// Begins to bring arm and winch to rest for good.
  void orderly_stop();
  [[nodiscard]] bool stopped() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace motionlab::service
