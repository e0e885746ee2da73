#include "drivers/mru/mru_wire_bin23.hpp"

namespace motionlab::mru::bin23 {
namespace {

constexpr std::uint8_t kFirst = 0xAA;
constexpr std::uint8_t kSecond = 0x51;
constexpr double kCount_rad = 90.0 * kDegree / (1 << 14);
constexpr double kCount_deg = 90.0 / (1 << 14);
constexpr double kCentimetre = 0.01;
constexpr std::uint16_t kTenthsPerSecond = 10'000;
constexpr Nanoseconds kTenth{100'000};
/// The CRC covers what lies between the two header bytes and itself.
constexpr std::size_t kHeader = 2;
constexpr std::size_t kCovered = kSize - kHeader - 2;

/// Walks through the fields in the order of the wire, reading or writing: one list for both directions.
template <class F, class Visit>
void for_each_field(F& frame, Visit&& visit) {
  visit(frame.utc_s);
  visit(frame.utc_tenths_of_ms);
  visit(frame.latitude_counts);
  visit(frame.longitude_counts);
  visit(frame.height_up_cm);
  visit(frame.heave_down_cm);
  for (auto& value : frame.v_ned_cmps) visit(value);
  visit(frame.roll_counts);
  visit(frame.pitch_counts);
  visit(frame.heading_counts);
  for (auto& value : frame.rate_counts) visit(value);
  visit(frame.status);
}

}  // namespace

std::uint16_t crc(Bytes bytes) noexcept {
  std::uint32_t remainder = 0xFFFF;
  for (const std::uint8_t byte : bytes) {
    remainder ^= byte;
    for (int bit = 0; bit < 8; ++bit) {
      remainder = (remainder & 1) != 0 ? remainder >> 1 ^ 0x8408 : remainder >> 1;
    }
  }
  return static_cast<std::uint16_t>(~remainder);
}

Result<Frame> decode(Bytes datagram) noexcept {
  if (datagram.size() < kSize) return Fault{Reason::too_short, "shorter than the 44 bytes of BIN23"};
  if (datagram.size() > kSize) return Fault{Reason::too_long, "longer than the 44 bytes of BIN23"};
  BigReader reader{datagram};
  if (reader.read<std::uint8_t>() != kFirst || reader.read<std::uint8_t>() != kSecond) {
    return Fault{Reason::bad_header, "the first bytes are not AA 51: the port does not carry BIN23"};
  }
  Frame frame;
  for_each_field(frame, [&]<class T>(T& field) { field = reader.read<T>(); });
  if (frame.utc_tenths_of_ms >= kTenthsPerSecond) {
    return Fault{Reason::bad_value, "a second of BIN23 has more than 9999 parts: the datagram is damaged"};
  }
  // Unlike all the rest, the CRC has its low byte first.
  frame.crc_good =
      load<std::uint16_t, std::endian::little>(datagram.last(2)) == crc(datagram.subspan(kHeader, kCovered));
  return frame;
}

Result<Bytes> encode(const Frame& frame, MutableBytes to) noexcept {
  if (to.size() < kSize) return Fault{Reason::too_short, "no room for the datagram"};
  const MutableBytes datagram = to.first(kSize);
  BigWriter writer{datagram};
  writer.write(kFirst);
  writer.write(kSecond);
  for_each_field(frame, [&](const auto& field) { writer.write(field); });
  store<std::endian::little>(datagram.last(2), crc(datagram.subspan(kHeader, kCovered)));
  return Bytes{datagram};
}

Motion motion_of(const Frame& frame) noexcept {
  const auto said = [&](unsigned bits) { return (frame.status & bits) != 0; };
  Motion motion;
  motion.stable = !said(kRollPitchInvalid | kHeaveInvalid);
  motion.reduced = said(kRollPitchReduced | kHeaveReduced | kHeadingReduced);
  motion.t_unit = UnitTime::of(std::chrono::seconds{frame.utc_s} + frame.utc_tenths_of_ms * kTenth);
  double& yaw = motion.euler_heading_mru_rad[2];
  motion.euler_heading_mru_rad[0] = kCount_rad * frame.roll_counts;
  motion.euler_heading_mru_rad[1] = kCount_rad * frame.pitch_counts;
  if (!said(kHeadingInvalid)) yaw = yaw_of_heading(kCount_deg * frame.heading_counts);
  for (std::size_t i = 0; i < 3; ++i) motion.omega_mru_radps[i] = kCount_rad * frame.rate_counts[i];
  Motion::Triple v_ned_mps{};
  for (std::size_t i = 0; i < 3; ++i) v_ned_mps[i] = kCentimetre * frame.v_ned_cmps[i];
  motion.v_heading_origin_mps = heading_from_ned(v_ned_mps, yaw);
  if (said(kPositionInvalid)) motion.v_heading_origin_mps[0] = motion.v_heading_origin_mps[1] = kNotTold;
  if (!said(kHeaveInvalid)) {
    motion.p_heading_origin_m[2] = kCentimetre * frame.heave_down_cm;
  } else {
    motion.v_heading_origin_mps[2] = kNotTold;
  }
  return motion;
}

Frame frame_of(const Motion& motion, Nanoseconds t_utc) noexcept {
  const auto& [roll, pitch, yaw] = motion.euler_heading_mru_rad;
  const auto whole = std::chrono::floor<std::chrono::seconds>(t_utc);
  Frame frame;
  frame.utc_s = static_cast<std::int32_t>(whole.count());
  frame.utc_tenths_of_ms = static_cast<std::uint16_t>((t_utc - whole) / kTenth);
  frame.heave_down_cm = to_counts<std::int16_t>(motion.p_heading_origin_m[2], kCentimetre);
  const Motion::Triple v_ned_mps = ned_from_heading(motion.v_heading_origin_mps, yaw);
  for (std::size_t i = 0; i < 3; ++i) {
    frame.v_ned_cmps[i] = to_counts<std::int16_t>(v_ned_mps[i], kCentimetre);
    frame.rate_counts[i] = to_counts<std::int16_t>(motion.omega_mru_radps[i], kCount_rad);
  }
  frame.roll_counts = to_counts<std::int16_t>(roll, kCount_rad);
  frame.pitch_counts = to_counts<std::int16_t>(pitch, kCount_rad);
  const auto heading = to_counts<std::uint32_t>(heading_of_yaw(yaw), kCount_deg);
  frame.heading_counts = static_cast<std::uint16_t>(heading);  // a whole turn is 2^16: rounding up to it is 0
  if (!motion.stable) frame.status |= kRollPitchInvalid | kHeaveInvalid;
  if (motion.reduced) frame.status |= kRollPitchReduced | kHeaveReduced | kHeadingReduced;
  return frame;
}

}  // namespace motionlab::mru::bin23
