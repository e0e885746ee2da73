/// @file  Whether a unit still measures, or only repeats itself.
#pragma once

#include <optional>

#include "drivers/core/time.hpp"
#include "drivers/mru/mru_wire_motion.hpp"

namespace motionlab::mru {

/// Notices values that stand still to the last bit while datagrams go on. A sensor has noise: in
/// floating-point rates and accelerations the same bits do not come for long from a unit that measures.
class Stillness {
 public:
  /// @param limit  0: nothing is ever stuck
  explicit Stillness(Nanoseconds limit) noexcept : limit_(limit) {}

  /// Takes the next motion. @returns whether its values have stood still for longer than the limit
  [[nodiscard]] bool stuck(const Motion& motion, LabTime t_received) noexcept;

 private:
  Nanoseconds limit_;
  std::optional<Motion> last_;
  LabTime moved_{};  ///< when the values last changed
};

}  // namespace motionlab::mru
