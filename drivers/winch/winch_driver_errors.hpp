/// @file  Where an error comes from, how often, and a sentence about it for people.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "drivers/core/time.hpp"
#include "drivers/winch/winch_wire.hpp"

namespace motionlab::winch {

/// How far a request came. What happens below, on the TCP connection, has no code: see the advice.
enum class ErrorLevel : std::uint8_t {
  router,  ///< error of the AMS header: it never reached the ADS device
  device,  ///< the ADS device's own answer
  drive,   ///< the axis or the drive behind it: S-0-0390, or the NC's number where that is 0
};

/// Level, place and number of an error.
struct ErrorReport {
  ErrorLevel level{};
  std::uint32_t code = 0;  ///< of router and device: see describe()
  AdsCommand command{};    ///< what was asked; of no meaning at the drive's level
  LabTime t_first{};
  LabTime t_last{};
  std::uint64_t count = 0;
};

/// "ADS device: Write was answered with 0x708 (1800), busy: the device is busy"
[[nodiscard]] std::string to_sentence(const ErrorReport& report);

/// Keeps the newest error, and counts it as long as it is the same.
class ErrorLog {
 public:
  /// @returns true when the error is another one than before
  bool note(ErrorLevel level, std::uint32_t code, AdsCommand command, LabTime t) noexcept {
    if (newest_ && newest_->code == code && newest_->level == level) {
      newest_->t_last = t;
      ++newest_->count;
      return false;
    }
    newest_ = ErrorReport{level, code, command, t, t, 1};
    return true;
  }
  [[nodiscard]] const std::optional<ErrorReport>& newest() const noexcept { return newest_; }

 private:
  std::optional<ErrorReport> newest_;
};

}  // namespace motionlab::winch
