/// @file  `DdsBus`: carries chosen topics between this process's LocalBus and the world. Fast DDS stays
/// behind it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "drivers/core/time.hpp"
#include "gateway/bus/dds_config.hpp"
#include "gateway/bus/local_bus.hpp"

namespace motionlab::bus {

/// What happened since the start. Nothing here is fatal; a number that grows is a reason to look.
struct DdsCounters {
  std::uint64_t written = 0;
  std::uint64_t write_failed = 0;
  std::uint64_t taken = 0;               ///< samples from DDS that local readers got
  std::uint64_t refused_malformed = 0;   ///< bytes that are no sample of the type
  std::uint64_t refused_text = 0;        ///< a text longer than its bound
  std::uint64_t refused_enum = 0;        ///< a number that is no enumerator
  std::uint64_t refused_not_finite = 0;  ///< NaN or infinity
  std::uint64_t refused_instance = 0;  ///< the instance has a publisher in this process, or the table is full
  std::uint64_t refused_flood = 0;     ///< more requests or references than a control step can take
  std::uint64_t lost_locally = 0;      ///< published here faster than the bus thread could write
  std::uint64_t deadline_missed = 0;   ///< by a writer or reader of this process
  std::uint64_t liveliness_lost = 0;   ///< a remote writer of commands fell silent
  std::uint64_t incompatible_qos = 0;  ///< an endpoint elsewhere that asks or offers something else

  [[nodiscard]] std::uint64_t refused() const noexcept {
    return refused_malformed + refused_text + refused_enum + refused_not_finite + refused_instance +
           refused_flood;
  }
};

/// One DDS participant. Say which topics go out and come in, then `start()` (a thread of its own, called
/// "bus") or call `run_once` from a thread of yours. All DDS calls happen there, never on a publisher's
/// thread.
///
/// The transport is UDP only: no segments are left in /dev/shm when a process is killed. A peer that was
/// killed is noticed after two seconds, a silent writer of commands after `kCommandLiveliness`. Whatever
/// arrives from outside is bounds-checked; what is refused is counted, and cannot end the process. Of
/// requests and references no more is handed on than a control step can take (flood_gate.hpp); a settle
/// always is.
class DdsBus {
 public:
  /// @param local  must outlive this
  /// @throws StartupError  with advice: unknown interface, bad domain, no participant
  DdsBus(const DdsConfig& config, LocalBus& local);
  ~DdsBus();
  DdsBus(const DdsBus&) = delete;
  DdsBus& operator=(const DdsBus&) = delete;

  /// From now on, what is published here goes out. Before `start`.
  /// @throws StartupError  when T already comes in, or is of the truth and `join_truth` is false
  template <class T>
  void out();

  /// From now on, what arrives is published here. Before `start`.
  /// @throws StartupError  when T already goes out, or is of the truth and `join_truth` is false
  template <class T>
  void in();

  /// Both: what is published here by others than this bus goes out, of a topic that has a period the newest
  /// once per period; what arrives from other participants is published here. Before `start`.
  /// @throws StartupError  as above
  template <class T>
  void both();

  /// Waits until there is something to do, at most `timeout`, and does it.
  /// @returns how many samples were written or taken
  std::size_t run_once(Nanoseconds timeout);

  void start();
  /// Ends the thread. Samples that were published before are written first.
  void stop();

  /// Endpoints that match ours for T now, of a topic that goes both ways our own among them. A volatile
  /// sample (command, request) that is written before the reader has matched us as well may be lost: repeat a
  /// request until its effect is seen.
  template <class T>
  [[nodiscard]] std::size_t matched() const;

  [[nodiscard]] DdsCounters counters() const;
  /// How often `run_once` has returned: at least ten times a second while the thread of `start` is well.
  [[nodiscard]] std::uint64_t rounds() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace motionlab::bus
