#include "drivers/mru/mru_wire_em3000.hpp"

#include <cstdlib>

namespace motionlab::mru::em3000 {
namespace {

constexpr std::uint8_t kMark = 0x90;
constexpr double kCentidegree = 0.01 * kDegree;
constexpr double kCentimetre = 0.01;
constexpr int kAngleMax_cdeg = 17999;
constexpr int kHeaveMax_cm = 999;
constexpr int kHeadingMax_cdeg = 35999;

}  // namespace

Result<Frame> decode(Bytes datagram) noexcept {
  if (datagram.size() < kSize) return Fault{Reason::too_short, "shorter than the 10 bytes of EM3000"};
  if (datagram.size() > kSize) return Fault{Reason::too_long, "longer than the 10 bytes of EM3000"};
  LittleReader reader{datagram};
  Frame frame;
  frame.status = reader.read<std::uint8_t>();
  if (reader.read<std::uint8_t>() != kMark) {
    return Fault{Reason::bad_header, "the second byte is not 0x90: the port does not carry EM3000"};
  }
  if (frame.status != kEm1000 && (frame.status < kNormal || frame.status > kLastError)) {
    return Fault{Reason::bad_header, "the status byte is none of EM3000: the datagram is damaged"};
  }
  frame.roll_cdeg = reader.read<std::int16_t>();
  frame.pitch_cdeg = reader.read<std::int16_t>();
  frame.heave_up_cm = reader.read<std::int16_t>();
  frame.heading_cdeg = reader.read<std::uint16_t>();
  return frame;
}

Result<Bytes> encode(const Frame& frame, MutableBytes to) noexcept {
  if (to.size() < kSize) return Fault{Reason::too_short, "no room for the datagram"};
  LittleWriter writer{to.first(kSize)};
  writer.write(frame.status);
  writer.write(kMark);
  writer.write(frame.roll_cdeg);
  writer.write(frame.pitch_cdeg);
  writer.write(frame.heave_up_cm);
  writer.write(frame.heading_cdeg);
  return Bytes{to.first(kSize)};
}

Result<Motion> motion_of(const Frame& frame) noexcept {
  if (std::abs(int{frame.roll_cdeg}) > kAngleMax_cdeg || std::abs(int{frame.pitch_cdeg}) > kAngleMax_cdeg) {
    return Fault{Reason::bad_value, "roll or pitch of EM3000 is out of range: the unit calls it invalid"};
  }
  Motion motion;
  motion.stable = frame.status < kFirstInvalid;
  motion.reduced = frame.status >= kFirstReduced && frame.status < kFirstInvalid;
  const double roll = kCentidegree * frame.roll_cdeg;
  const double pitch = kCentidegree * frame.pitch_cdeg;
  motion.euler_heading_mru_rad[0] = frame.status == kEm1000 ? euler_roll(roll, pitch) : roll;
  motion.euler_heading_mru_rad[1] = pitch;
  if (frame.heading_cdeg <= kHeadingMax_cdeg) {
    motion.euler_heading_mru_rad[2] = yaw_of_heading(0.01 * frame.heading_cdeg);
  }
  if (std::abs(int{frame.heave_up_cm}) <= kHeaveMax_cm) {
    motion.p_heading_origin_m[2] = -kCentimetre * frame.heave_up_cm;
  }
  return motion;
}

Frame frame_of(const Motion& motion, Format format) noexcept {
  const auto& [roll, pitch, yaw] = motion.euler_heading_mru_rad;
  const bool hippy = format == Format::em1000;
  Frame frame;
  frame.status = hippy ? kEm1000 : !motion.stable ? kFirstInvalid : motion.reduced ? kFirstReduced : kNormal;
  frame.roll_cdeg = to_counts<std::int16_t>(hippy ? hippy_roll(roll, pitch) : roll, kCentidegree);
  frame.pitch_cdeg = to_counts<std::int16_t>(pitch, kCentidegree);
  frame.heave_up_cm = to_counts<std::int16_t>(-motion.p_heading_origin_m[2], kCentimetre);
  frame.heading_cdeg = to_counts<std::uint16_t>(heading_of_yaw(yaw), 0.01);
  if (frame.heading_cdeg == kHeadingMax_cdeg + 1) frame.heading_cdeg = 0;
  return frame;
}

}  // namespace motionlab::mru::em3000
