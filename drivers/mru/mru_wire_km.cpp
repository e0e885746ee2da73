#include "drivers/mru/mru_wire_km.hpp"

#include <cmath>

namespace motionlab::mru::km {
namespace {

constexpr std::string_view kName = "#KMB";
constexpr std::uint16_t kVersion = 1;
constexpr std::uint32_t kNanosecondsPerSecond = 1'000'000'000;

/// Walks through the fields in the order of the wire, reading or writing: one list for both directions.
template <class F, class Visit>
void for_each_field(F& frame, Visit&& visit) {
  visit(frame.utc_s);
  visit(frame.utc_ns);
  visit(frame.status);
  visit(frame.latitude_deg);
  visit(frame.longitude_deg);
  visit(frame.height_up_m);
  for (auto& value : frame.roll_pitch_heading_deg) visit(value);
  visit(frame.heave_down_m);
  for (auto& value : frame.rates_degps) visit(value);
  for (auto& value : frame.v_ned_mps) visit(value);
  for (auto& value : frame.position_error_m) visit(value);
  for (auto& value : frame.roll_pitch_heading_error_deg) visit(value);
  visit(frame.heave_error_m);
  for (auto& value : frame.a_ned_mps2) visit(value);
  visit(frame.delayed_utc_s);
  visit(frame.delayed_utc_ns);
  visit(frame.delayed_heave_down_m);
}

}  // namespace

Result<Frame> decode(Bytes datagram) noexcept {
  if (datagram.size() < kSize) return Fault{Reason::too_short, "shorter than the 132 bytes of KM Binary"};
  if (datagram.size() > kSize) return Fault{Reason::too_long, "longer than the 132 bytes of KM Binary"};
  LittleReader reader{datagram};
  if (as_text(reader.take(kName.size())) != kName) {
    return Fault{Reason::bad_header, "the first bytes are not #KMB: the port does not carry KM Binary"};
  }
  if (reader.read<std::uint16_t>() != kSize) {
    return Fault{Reason::bad_header, "the length field of KM Binary is not 132"};
  }
  if (reader.read<std::uint16_t>() != kVersion) {
    return Fault{Reason::bad_header, "another version of KM Binary than 1: set the unit to version 1"};
  }
  Frame frame;
  bool finite = true;
  for_each_field(frame, [&]<class T>(T& field) {
    field = reader.read<T>();
    if constexpr (std::floating_point<T>) finite = finite && std::isfinite(field);
  });
  if (!finite) {
    return Fault{Reason::bad_value, "a number of KM Binary is not finite: the unit is faulty"};
  }
  if (frame.utc_ns >= kNanosecondsPerSecond || frame.delayed_utc_ns >= kNanosecondsPerSecond) {
    return Fault{Reason::bad_value, "a second of KM Binary has more than 1e9 ns: the datagram is damaged"};
  }
  return frame;
}

Result<Bytes> encode(const Frame& frame, MutableBytes to) noexcept {
  if (to.size() < kSize) return Fault{Reason::too_short, "no room for the datagram"};
  LittleWriter writer{to.first(kSize)};
  writer.write_bytes(as_bytes(kName));
  writer.write(static_cast<std::uint16_t>(kSize));
  writer.write(kVersion);
  for_each_field(frame, [&](const auto& field) { writer.write(field); });
  return Bytes{to.first(kSize)};
}

Motion motion_of(const Frame& frame) noexcept {
  const auto invalid = [&](std::uint32_t subject) { return (frame.status & subject) != 0; };
  const auto scaled = [](const std::array<float, 3>& values, double unit) {
    return Motion::Triple{unit * static_cast<double>(values[0]), unit * static_cast<double>(values[1]),
                          unit * static_cast<double>(values[2])};
  };
  Motion motion;
  motion.stable = !invalid(kRollPitch) && !invalid(kHeave);
  motion.reduced = (frame.status >> kReduced & (kRollPitch | kHeading | kHeave | kAcceleration)) != 0;
  motion.t_unit = UnitTime::of(std::chrono::seconds{frame.utc_s} + Nanoseconds{frame.utc_ns});
  motion.euler_heading_mru_rad = scaled(frame.roll_pitch_heading_deg, kDegree);
  double& yaw = motion.euler_heading_mru_rad[2];
  yaw = invalid(kHeading) ? kNotTold : yaw_of_heading(static_cast<double>(frame.roll_pitch_heading_deg[2]));
  motion.omega_mru_radps = scaled(frame.rates_degps, kDegree);
  motion.p_heading_origin_m[2] = static_cast<double>(frame.heave_down_m);
  motion.v_heading_origin_mps = heading_from_ned(scaled(frame.v_ned_mps, 1.0), yaw);
  if (invalid(kPosition)) motion.v_heading_origin_mps[0] = motion.v_heading_origin_mps[1] = kNotTold;
  if (invalid(kHeave)) motion.p_heading_origin_m[2] = motion.v_heading_origin_mps[2] = kNotTold;
  if (!invalid(kAcceleration)) {
    motion.a_heading_origin_mps2 = heading_from_ned(scaled(frame.a_ned_mps2, 1.0), yaw);
  }
  return motion;
}

Frame frame_of(const Motion& motion, Nanoseconds t_utc) noexcept {
  const auto scaled = [](const Motion::Triple& values, double unit) {
    return std::array<float, 3>{static_cast<float>(values[0] / unit), static_cast<float>(values[1] / unit),
                                static_cast<float>(values[2] / unit)};
  };
  const auto whole = std::chrono::floor<std::chrono::seconds>(t_utc);
  const double yaw = motion.euler_heading_mru_rad[2];
  Frame frame;
  frame.utc_s = static_cast<std::uint32_t>(whole.count());
  frame.utc_ns = static_cast<std::uint32_t>((t_utc - whole).count());
  if (!motion.stable) frame.status |= kRollPitch | kHeave;
  if (motion.reduced) frame.status |= (kRollPitch | kHeading | kHeave) << kReduced;
  frame.roll_pitch_heading_deg = scaled(motion.euler_heading_mru_rad, kDegree);
  frame.roll_pitch_heading_deg[2] = static_cast<float>(heading_of_yaw(yaw));
  frame.heave_down_m = static_cast<float>(motion.p_heading_origin_m[2]);
  frame.rates_degps = scaled(motion.omega_mru_radps, kDegree);
  frame.v_ned_mps = scaled(ned_from_heading(motion.v_heading_origin_mps, yaw), 1.0);
  frame.a_ned_mps2 = scaled(ned_from_heading(motion.a_heading_origin_mps2, yaw), 1.0);
  frame.position_error_m = {-1.0F, -1.0F, -1.0F};
  frame.delayed_utc_s = frame.utc_s;
  frame.delayed_utc_ns = frame.utc_ns;
  frame.status |= kDelayedHeave;
  return frame;
}

}  // namespace motionlab::mru::km
