/// @file  `Recorder`: what is said on the bus into files, with a thread for each end of the queue between
/// them.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "drivers/core/real_clock.hpp"
#include "gateway/bus/dds_tap.hpp"
#include "gateway/monitor/event_windows.hpp"
#include "gateway/record/recording.hpp"
#include "gateway/record/sample_queue.hpp"

namespace motionlab::monitor {

/// Records from its birth to `finish`. Whoever owns it calls `listen` again and again: there samples are
/// taken from DDS. A thread of its own ("recorder") compresses and writes; a slow disk costs samples, which
/// are counted, but DDS never waits for it.
class Recorder {
 public:
  /// @param window  nothing: everything is recorded; else what surrounds its events, into a part for each
  /// @throws StartupError  no DDS, or the file cannot be made
  Recorder(const bus::DdsConfig& dds, const bus::TapOptions& tap, record::RecordingOptions options,
           const std::optional<EventWindow>& window = {});
  ~Recorder();
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  /// Takes what has arrived. One thread. @returns how many samples
  std::size_t listen();
  /// Ends the file; after that the recording may be asked.
  const record::Recording& finish();

  /// Losses up to now. The thread that listens.
  [[nodiscard]] const record::LossesByTopic& losses() noexcept { return queue_.ledger().all(); }
  /// How often the writing thread has come round: it does some times a second while it is well.
  [[nodiscard]] std::uint64_t rounds() const noexcept { return rounds_.load(std::memory_order_relaxed); }
  [[nodiscard]] std::uint64_t messages() const noexcept { return messages_.load(std::memory_order_relaxed); }
  [[nodiscard]] std::uint64_t bytes() const noexcept { return bytes_.load(std::memory_order_relaxed); }
  /// Events that opened a window.
  [[nodiscard]] std::uint64_t windows() const noexcept { return opened_.load(std::memory_order_relaxed); }
  /// What keeps it from writing, as a sentence.
  [[nodiscard]] std::optional<std::string> trouble() const;

 private:
  void write();

  RealClock clock_;
  bus::DdsTap tap_;
  record::SampleQueue queue_;
  record::Recording recording_;          ///< of the thread, until that has ended
  std::optional<EventWindows> windows_;  ///< likewise
  std::atomic<bool> stopping_{false};
  std::atomic<std::uint64_t> rounds_{0}, messages_{0}, bytes_{0}, opened_{0};
  mutable std::mutex mutex_;
  std::optional<std::string> trouble_;
  std::thread thread_;
};

}  // namespace motionlab::monitor
