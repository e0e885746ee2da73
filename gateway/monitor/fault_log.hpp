/// @file  Which faults there were, how soon the gateway noticed, and how soon nothing was commanded to move.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/core/time.hpp"
#include "idl/control.hpp"
#include "idl/mode.hpp"

namespace motionlab::monitor {

/// Pairs faults that somebody caused with faults that the gateway latched.
class FaultLog {
 public:
  static constexpr std::size_t kMost = 1000;  ///< further ones are not logged

  struct Entry {
    LabTime t;         ///< when it was caused; when it was latched if nobody said that he caused it
    std::string name;  ///< of what was caused; else the code that was latched
    bool caused = false;
    std::string code;                ///< that the gateway latched; empty while it has not noticed
    std::optional<LabTime> latched;  ///< nothing while it has not noticed
    std::optional<LabTime> at_rest;  ///< first control step since the latch whose command moves nothing
  };

  /// Somebody caused a fault. A latch is taken for the consequence of the newest one without any.
  void caused(LabTime t, std::string_view name);
  void take(const topic::Mode& mode);
  void take(const topic::Control& control);

  [[nodiscard]] const std::vector<Entry>& entries() const { return entries_; }

 private:
  std::vector<Entry> entries_;
  std::optional<LabTime> newest_latch_;
};

}  // namespace motionlab::monitor
