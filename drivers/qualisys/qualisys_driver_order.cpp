#include "drivers/qualisys/qualisys_driver_order.hpp"

namespace motionlab::qualisys {

namespace {

/// A time stamp that goes back by less than this is a late datagram, by more it may be a new measurement.
constexpr std::uint64_t kRestart_us = 500'000;
/// No camera of QTM's is faster. A number that ran ahead of this was damaged on its way, or another
/// measurement's.
constexpr std::uint64_t kFastestFrame_us = 100;

}  // namespace

FrameOrder::Verdict FrameOrder::judge(const DataFrame& packet) noexcept {
  Verdict verdict;
  if (has_last_ && packet.timestamp_us == timestamp_us_) {
    if (packet.frame_number != frame_number_ || packet.present.empty() || packet.present.overlaps(seen_)) {
      verdict.fault = Fault{Reason::duplicate, "frame came twice"};
      return verdict;
    }
    seen_.add(packet.present);
    return verdict;
  }
  if (has_last_ && packet.timestamp_us < timestamp_us_) {
    const bool far_back = timestamp_us_ - packet.timestamp_us > kRestart_us;
    verdict.restarted = far_back && restart_us_ && packet.timestamp_us > *restart_us_ &&
                        packet.timestamp_us - *restart_us_ < kRestart_us;
    if (!verdict.restarted) {
      restart_us_ = far_back ? std::optional{packet.timestamp_us} : std::nullopt;
      verdict.fault = Fault{Reason::out_of_order, "frame is older than the one before"};
      return verdict;
    }
  }
  if (has_last_ && !verdict.restarted && packet.frame_number > frame_number_) {
    const std::uint64_t missing = packet.frame_number - frame_number_ - 1;
    if (missing <= (packet.timestamp_us - timestamp_us_) / kFastestFrame_us) verdict.lost = missing;
  }
  verdict.first_part = true;
  has_last_ = true;
  timestamp_us_ = packet.timestamp_us;
  frame_number_ = packet.frame_number;
  seen_ = packet.present;
  restart_us_.reset();
  return verdict;
}

}  // namespace motionlab::qualisys
