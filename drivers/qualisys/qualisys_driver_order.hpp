/// @file  Which packet is a new frame, which a further part of one, and which comes too late.
#pragma once

#include <cstdint>
#include <optional>

#include "drivers/core/result.hpp"
#include "drivers/qualisys/qualisys_wire_data.hpp"

namespace motionlab::qualisys {

/// Judges packets by QTM's time stamp: the frame number stands still in some live modes, and its gaps are
/// normal. A frame that does not fit one datagram comes in several, of one stamp and number, each with
/// components of its own.
///
/// A stamp that went back by half a second or more begins a new measurement once two packets in a row say so;
/// until then it is a late packet, and refused.
class FrameOrder {
 public:
  struct Verdict {
    std::optional<Fault> fault;  ///< duplicate, out_of_order
    bool first_part = false;     ///< of a new frame
    bool restarted = false;      ///< QTM's time began again: nothing learned of it holds any more
    std::uint64_t lost =
        0;  ///< frames that the number says are missing before this one, if time allows so many
  };

  [[nodiscard]] Verdict judge(const DataFrame& packet) noexcept;
  /// What the newest frame has brought so far.
  [[nodiscard]] const Components& seen() const noexcept { return seen_; }
  void reset() noexcept { *this = {}; }

 private:
  bool has_last_ = false;
  std::uint64_t timestamp_us_ = 0;
  std::uint32_t frame_number_ = 0;
  Components seen_;
  std::optional<std::uint64_t> restart_us_;  ///< a stamp that would mean a restart, if the next agrees
};

}  // namespace motionlab::qualisys
