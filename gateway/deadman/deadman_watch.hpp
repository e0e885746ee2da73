/// @file  Whether the gateway still lives: which beat was missed, judged without a clock of its own.
#pragma once

#include <cstdint>
#include <optional>

#include "drivers/core/time.hpp"
#include "gateway/deadman/page/page.hpp"

namespace motionlab::deadman {

/// What the deadman sees when it looks.
struct Sight {
  Phase phase = Phase::serving;
  std::uint64_t io_beats = 0;
  std::uint64_t control_beats = 0;
  bool gone = false;  ///< the pipe is closed, or the process has ended
};

/// What follows from it.
enum class Verdict : std::uint8_t {
  alive,
  ended,           ///< in order: the deadman is not needed any more
  gone,            ///< crashed or killed: bring arm and winch to rest
  io_silent,       ///< it is there and its io thread does not beat: kill it, then as gone
  control_silent,  ///< likewise its control thread
};

/// Judges the gateway, look after look.
///
/// A thread is silent when its counter has stood still for as long as is allowed, counted from its first beat
/// on and while the gateway serves. What counts is not time but the deadman's own looks: each counts the time
/// since the one before, but never more than one period. So a machine that stood still for a while, deadman
/// and all, accuses nobody.
class DeadmanWatch {
 public:
  struct Config {
    Nanoseconds look_period{};
    Nanoseconds io_silent_after{};
    Nanoseconds control_silent_after{};
  };

  explicit DeadmanWatch(const Config& config) noexcept : config_(config) {}

  /// @param now  of any clock that runs evenly
  [[nodiscard]] Verdict look(LabTime now, const Sight& sight) noexcept;

 private:
  /// One counter and for how long it stands still.
  class Pulse {
   public:
    /// @returns for how long it has been silent
    Nanoseconds look(std::uint64_t beats, Nanoseconds counted) noexcept;

   private:
    std::uint64_t seen_ = 0;
    Nanoseconds silent_{0};
  };

  Config config_;
  std::optional<LabTime> t_looked_;
  Pulse io_;
  Pulse control_;
};

}  // namespace motionlab::deadman
