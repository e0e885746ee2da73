/// @file  Whether every thread still comes round: what lets the service manager's watchdog be stroked.
#pragma once

#include <cstdint>
#include <string>

namespace motionlab::service {

/// How often each thread has come round its loop since the start. A thread that hangs stops counting.
struct Rounds {
  std::uint64_t io = 0;
  std::uint64_t control = 0;
  std::uint64_t bus = 0;
};

/// Asks io, control and bus the same question again and again: have you come round since you last answered?
class RoundsCheck {
 public:
  /// @returns true when every thread has come round since this last returned true (at first: since the start)
  bool all_came_round(const Rounds& now) {
    silent_.clear();
    const auto ask = [this](std::uint64_t before, std::uint64_t count, const char* thread) {
      if (count == before) silent_ += (silent_.empty() ? "" : ", ") + std::string(thread);
    };
    ask(answered_.io, now.io, "io");
    ask(answered_.control, now.control, "control");
    ask(answered_.bus, now.bus, "bus");
    if (!silent_.empty()) return false;
    answered_ = now;
    return true;
  }

  /// The threads that had not answered when last asked, e.g. "io, bus"; empty when all had.
  [[nodiscard]] const std::string& silent() const { return silent_; }

 private:
  Rounds answered_;
  std::string silent_;
};

}  // namespace motionlab::service
