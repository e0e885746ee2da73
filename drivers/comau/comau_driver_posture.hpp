/// @file  Whether the arm can be where an answer says that it is.
#pragma once

#include <optional>

#include "drivers/comau/comau_wire.hpp"
#include "drivers/core/result.hpp"
#include "drivers/core/time.hpp"

namespace motionlab::comau {

/// Refuses postures that a Comau Smart 5 NJ 110-3.0 cannot be in, or cannot have come to since the last one
/// that was accepted. Strokes and greatest speeds are those of the laboratory's own controller file. Random
/// bytes and offsets that come at once are caught so; a posture that was wrong from the beginning is not, nor
/// one that goes wrong slowly.
class PostureCheck {
 public:
  /// @param passed  time since the last accepted answer, by whichever clock says more
  /// Faults: bad_value.
  [[nodiscard]] Status check(const Answer& answer, Nanoseconds passed) const noexcept;
  void accept(const Answer& answer) noexcept { last_rad_ = answer.q_rad; }

 private:
  std::optional<Joints> last_rad_;
};

}  // namespace motionlab::comau
