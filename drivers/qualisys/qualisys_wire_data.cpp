#include "drivers/qualisys/qualisys_wire_data.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "drivers/qualisys/qualisys_wire.hpp"

namespace motionlab::qualisys {

namespace {

enum class ComponentType : std::uint32_t { bodies = 5, bodies_with_residual = 11, timecode = 17 };
enum class TimecodeKind : std::uint32_t { smpte = 0, irig = 1, camera = 2 };

constexpr std::size_t kComponentHeaderSize = 8;
constexpr std::size_t kBodiesHeadSize = 8;  // count, drop rate, out-of-sync rate
constexpr std::size_t kPoseFloats = 12;     // x y z m0…m8
constexpr std::size_t kTimecodeItemSize = 12;
constexpr double kMetresPerMillimetre = 1e-3;
constexpr std::int64_t kNanosecondsPerTick = 100;
constexpr float kLost = std::bit_cast<float>(0xFFFFFFFFu);

/// Row-major, as mathematics writes it; the wire is column-major.
using Matrix = std::array<std::array<double, 3>, 3>;

bool is_rotation(const Matrix& r) noexcept {
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      const double dot = r[0][i] * r[0][j] + r[1][i] * r[1][j] + r[2][i] * r[2][j];
      if (!(std::abs(dot - (i == j ? 1.0 : 0.0)) <= kRotationTolerance)) return false;
    }
  }
  const double determinant = r[0][0] * (r[1][1] * r[2][2] - r[1][2] * r[2][1]) -
                             r[0][1] * (r[1][0] * r[2][2] - r[1][2] * r[2][0]) +
                             r[0][2] * (r[1][0] * r[2][1] - r[1][1] * r[2][0]);
  return determinant > 0.0;
}

/// Unit quaternion w, x, y, z with w >= 0. Starts from the largest component, so that it never divides by a
/// small one.
std::array<double, 4> to_quaternion(const Matrix& r) noexcept {
  const double trace = r[0][0] + r[1][1] + r[2][2];
  std::array<double, 4> q{};
  if (trace > 0.0) {
    q = {1.0 + trace, r[2][1] - r[1][2], r[0][2] - r[2][0], r[1][0] - r[0][1]};
  } else {
    std::size_t i = 0;
    if (r[1][1] > r[0][0]) i = 1;
    if (r[2][2] > r[i][i]) i = 2;
    const std::size_t j = (i + 1) % 3;
    const std::size_t k = (i + 2) % 3;
    q[0] = r[k][j] - r[j][k];
    q[1 + i] = 1.0 + r[i][i] - r[j][j] - r[k][k];
    q[1 + j] = r[j][i] + r[i][j];
    q[1 + k] = r[k][i] + r[i][k];
  }
  const double norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  const double scale = q[0] < 0.0 ? -1.0 / norm : 1.0 / norm;
  for (double& element : q) element *= scale;
  return q;
}

Matrix to_matrix(const std::array<double, 4>& q) noexcept {
  const auto [w, x, y, z] = q;
  return {{{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
           {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
           {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}}};
}

Result<BodyPose> read_body(LittleReader& reader, bool with_residual) noexcept {
  std::array<double, kPoseFloats> value{};
  bool finite = true;
  for (double& v : value) {
    v = static_cast<double>(reader.read<float>());
    finite = finite && std::isfinite(v);
  }
  const double residual_mm = with_residual ? static_cast<double>(reader.read<float>()) : 0.0;
  if (!finite || !std::isfinite(residual_mm)) return BodyPose{};

  BodyPose pose;
  pose.tracked = true;
  for (std::size_t i = 0; i < 3; ++i) {
    pose.p_camera_body_m[i] = value[i] * kMetresPerMillimetre;
    if (std::abs(pose.p_camera_body_m[i]) > kPositionLimit_m)
      return Fault{Reason::bad_value, "body further away than any camera sees"};
  }
  Matrix r;
  for (std::size_t k = 0; k < 9; ++k) r[k % 3][k / 3] = value[3 + k];
  if (!is_rotation(r)) return Fault{Reason::bad_value, "orientation of a body is no rotation matrix"};
  pose.q_camera_body = to_quaternion(r);
  pose.residual_m = residual_mm * kMetresPerMillimetre;
  return pose;
}

double share(std::uint16_t per_mille) noexcept {
  return std::min(1e-3 * per_mille, 1.0);
}

/// @param body  the component behind its header
Status read_bodies(Bytes body, bool with_residual, DataFrame& frame) noexcept {
  LittleReader reader{body};
  const std::size_t count = reader.read<std::uint32_t>();
  const double drop_rate = share(reader.read<std::uint16_t>());
  const double out_of_sync_rate = share(reader.read<std::uint16_t>());
  if (!reader.ok()) return Fault{Reason::too_short, "component of bodies without a count"};
  if (count > kMaxBodies) return Fault{Reason::too_long, "more bodies than a frame of ours can hold"};
  const std::size_t stride = sizeof(float) * (kPoseFloats + (with_residual ? 1 : 0));
  if (reader.remaining() != count * stride)
    return Fault{Reason::bad_header, "size of the bodies' component does not fit their number"};

  frame.has_bodies = true;
  frame.drop_rate = drop_rate;
  frame.out_of_sync_rate = out_of_sync_rate;
  frame.body_count = count;
  for (std::size_t i = 0; i < count; ++i) {
    const auto pose = read_body(reader, with_residual);
    if (!pose) return pose.fault();
    frame.body[i] = *pose;
  }
  return Done{};
}

/// The `width` bits of a word from bit `first` on.
std::uint32_t bits(std::uint32_t word, int first, int width) noexcept {
  return (word >> first) & ((1u << width) - 1u);
}

Status read_timecodes(Bytes body, DataFrame& frame) noexcept {
  LittleReader reader{body};
  const std::size_t count = reader.read<std::uint32_t>();
  if (!reader.ok()) return Fault{Reason::too_short, "time code component without a count"};
  if (reader.remaining() / kTimecodeItemSize != count || reader.remaining() % kTimecodeItemSize != 0)
    return Fault{Reason::bad_header, "size of the time code component does not fit its count"};
  for (std::size_t i = 0; i < count; ++i) {
    const auto kind = static_cast<TimecodeKind>(reader.read<std::uint32_t>());
    const auto high = reader.read<std::uint32_t>();
    const auto low = reader.read<std::uint32_t>();
    if (kind == TimecodeKind::camera) {
      const std::uint64_t ticks = (std::uint64_t{high} << 32) | low;
      if (ticks > kTimeLimit_ns / kNanosecondsPerTick)
        return Fault{Reason::bad_value, "camera time beyond what can be"};
      frame.timecode = CameraTime{Nanoseconds{static_cast<std::int64_t>(ticks) * kNanosecondsPerTick}};
    } else if (!frame.timecode && kind == TimecodeKind::smpte) {
      frame.timecode =
          SmpteTime{bits(low, 0, 5), bits(low, 5, 6), bits(low, 11, 6), bits(low, 17, 5), bits(low, 22, 9)};
    } else if (!frame.timecode && kind == TimecodeKind::irig) {
      frame.timecode = IrigTime{bits(high, 0, 7), bits(high, 7, 9), bits(low, 0, 5),
                                bits(low, 5, 6),  bits(low, 11, 6), bits(low, 17, 4)};
    }
  }
  return Done{};
}

void write_body(LittleWriter& writer, const BodyPose& pose, bool with_residual) noexcept {
  if (!pose.tracked) {
    for (std::size_t i = 0; i < kPoseFloats + (with_residual ? 1 : 0); ++i) writer.write(kLost);
    return;
  }
  for (const double p : pose.p_camera_body_m) writer.write(static_cast<float>(p / kMetresPerMillimetre));
  const Matrix r = to_matrix(pose.q_camera_body);
  for (std::size_t k = 0; k < 9; ++k) writer.write(static_cast<float>(r[k % 3][k / 3]));
  if (with_residual) writer.write(static_cast<float>(pose.residual_m / kMetresPerMillimetre));
}

std::uint16_t per_mille(double rate) noexcept {
  return static_cast<std::uint16_t>(std::lround(std::clamp(rate, 0.0, 1.0) * 1000.0));
}

void write_bodies(LittleWriter& writer, const DataFrame& frame, bool with_residual) noexcept {
  const std::size_t stride = sizeof(float) * (kPoseFloats + (with_residual ? 1 : 0));
  writer.write(
      static_cast<std::uint32_t>(kComponentHeaderSize + kBodiesHeadSize + stride * frame.body_count));
  writer.write(static_cast<std::uint32_t>(with_residual ? ComponentType::bodies_with_residual
                                                        : ComponentType::bodies));
  writer.write(static_cast<std::uint32_t>(frame.body_count));
  writer.write(per_mille(frame.drop_rate));
  writer.write(per_mille(frame.out_of_sync_rate));
  for (const BodyPose& pose : frame.bodies()) write_body(writer, pose, with_residual);
}

struct TimecodeWords {
  TimecodeKind kind{};
  std::uint32_t high = 0;
  std::uint32_t low = 0;
};

TimecodeWords to_words(const SmpteTime& t) noexcept {
  return {TimecodeKind::smpte, 0,
          t.hours | t.minutes << 5 | t.seconds << 11 | t.frame << 17 | t.sub_frame << 22};
}
TimecodeWords to_words(const IrigTime& t) noexcept {
  return {TimecodeKind::irig, t.year | t.day_of_year << 7,
          t.hours | t.minutes << 5 | t.seconds << 11 | t.tenths << 17};
}
TimecodeWords to_words(const CameraTime& t) noexcept {
  const auto ticks = static_cast<std::uint64_t>(t.since_epoch.count() / kNanosecondsPerTick);
  return {TimecodeKind::camera, static_cast<std::uint32_t>(ticks >> 32), static_cast<std::uint32_t>(ticks)};
}

void write_timecode(LittleWriter& writer, const Timecode& timecode) noexcept {
  const TimecodeWords words = std::visit([](const auto& t) { return to_words(t); }, timecode);
  writer.write(static_cast<std::uint32_t>(kComponentHeaderSize + sizeof(std::uint32_t) + kTimecodeItemSize));
  writer.write(static_cast<std::uint32_t>(ComponentType::timecode));
  writer.write(std::uint32_t{1});
  writer.write(static_cast<std::uint32_t>(words.kind));
  writer.write(words.high);
  writer.write(words.low);
}

/// A component may come once. `seen` holds a bit for each that did.
bool first_time(ComponentType type, std::uint32_t& seen) noexcept {
  const std::uint32_t bit = 1u << static_cast<std::uint32_t>(type);
  const bool first = (seen & bit) == 0;
  seen |= bit;
  return first;
}

Status read_component(ComponentType type, Bytes body, std::uint32_t& seen, DataFrame& frame) noexcept {
  switch (type) {
    case ComponentType::bodies:
    case ComponentType::bodies_with_residual: {
      if (!first_time(type, seen)) break;
      const bool with_residual = type == ComponentType::bodies_with_residual;
      // Without residual it only fills in what the richer component has not given.
      if (!with_residual && frame.has_bodies) return Done{};
      return read_bodies(body, with_residual, frame);
    }
    case ComponentType::timecode:
      if (!first_time(type, seen)) break;
      return read_timecodes(body, frame);
    default:
      return Done{};
  }
  return Fault{Reason::bad_header, "the same component twice in one data packet"};
}

}  // namespace

Result<DataFrame> decode_data(Bytes payload) noexcept {
  LittleReader reader{payload};
  DataFrame frame;
  frame.timestamp_us = reader.read<std::uint64_t>();
  frame.frame_number = reader.read<std::uint32_t>();
  const auto component_count = reader.read<std::uint32_t>();
  if (!reader.ok()) return Fault{Reason::too_short, "data packet is shorter than its header"};
  if (frame.timestamp_us > kTimeLimit_ns / 1000)
    return Fault{Reason::bad_value, "frame time stamp beyond what can be"};

  std::uint32_t seen = 0;
  for (std::uint32_t i = 0; i < component_count; ++i) {
    const std::size_t size = reader.read<std::uint32_t>();
    const auto type = static_cast<ComponentType>(reader.read<std::uint32_t>());
    if (!reader.ok()) return Fault{Reason::too_short, "data packet has fewer components than it announces"};
    if (size < kComponentHeaderSize)
      return Fault{Reason::bad_header, "component announces fewer bytes than its own header has"};
    const Bytes body = reader.take(size - kComponentHeaderSize);
    if (!reader.ok()) return Fault{Reason::too_short, "component is longer than the data packet"};
    if (const Status status = read_component(type, body, seen, frame); !status) return status.fault();
  }
  if (reader.remaining() != 0) return Fault{Reason::too_long, "bytes behind the last component"};
  return frame;
}

Result<Bytes> encode_data(const DataFrame& frame, const Components& components, MutableBytes out) noexcept {
  const bool timecode = components.timecode && frame.timecode.has_value();
  LittleWriter writer{out};
  writer.write(std::uint32_t{0});  // the size, known at the end
  writer.write(static_cast<std::uint32_t>(PacketType::data));
  writer.write(frame.timestamp_us);
  writer.write(frame.frame_number);
  writer.write(static_cast<std::uint32_t>(int{components.bodies} + int{components.bodies_with_residual} +
                                          int{timecode}));
  if (components.bodies) write_bodies(writer, frame, false);
  if (components.bodies_with_residual) write_bodies(writer, frame, true);
  if (timecode) write_timecode(writer, *frame.timecode);
  if (!writer.ok()) return Fault{Reason::too_long, "data packet does not fit the buffer"};
  store<std::endian::little>(out, static_cast<std::uint32_t>(writer.position()));
  return writer.written();
}

}  // namespace motionlab::qualisys
