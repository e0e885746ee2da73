#include <algorithm>
#include <cmath>
#include <numbers>

#include "drivers/qualisys/qualisys_wire_data.hpp"
#include "drivers/qualisys/qualisys_wire_layout.hpp"
#include "drivers/qualisys/qualisys_wire_rotation.hpp"

namespace motionlab::qualisys {

namespace {

constexpr Fault kTooFar{Reason::bad_value, "body or marker further away than any camera sees"};
constexpr double kRadiansPerDegree = std::numbers::pi / 180.0;

/// N floats, and whether all of them are finite.
template <std::size_t N>
struct Floats {
  std::array<double, N> value{};
  bool finite = true;

  template <class Reader>
  explicit Floats(Reader& reader) noexcept {
    for (double& v : value) {
      v = static_cast<double>(reader.template read<float>());
      finite = finite && std::isfinite(v);
    }
  }
};

std::array<double, 3> metres(std::span<const double> millimetres) noexcept {
  return {millimetres[0] * kMetresPerMillimetre, millimetres[1] * kMetresPerMillimetre,
          millimetres[2] * kMetresPerMillimetre};
}

bool near(const std::array<double, 3>& p_m) noexcept {
  return std::all_of(p_m.begin(), p_m.end(), [](double p) { return std::abs(p) <= kPositionLimit_m; });
}

/// The residual in metres; 0 when the component has none.
template <class Reader>
double read_residual(Reader& reader, bool with_residual) noexcept {
  return with_residual ? static_cast<double>(reader.template read<float>()) * kMetresPerMillimetre : 0.0;
}

template <class Reader>
Result<BodyPose> read_item(Reader& reader, bool with_residual, BodyPose pose) noexcept {
  const Floats<12> floats{reader};
  pose.residual_m = read_residual(reader, with_residual);
  if (!floats.finite || !std::isfinite(pose.residual_m)) return BodyPose{};
  pose.tracked = true;
  pose.p_camera_body_m = metres(floats.value);
  if (!near(pose.p_camera_body_m)) return kTooFar;
  Matrix r;
  for (std::size_t k = 0; k < 9; ++k) r[k % 3][k / 3] = floats.value[3 + k];
  if (!is_rotation(r)) return Fault{Reason::bad_value, "orientation of a body is no rotation matrix"};
  pose.q_camera_body = to_quaternion(r);
  return pose;
}

template <class Reader>
Result<BodyAngles> read_item(Reader& reader, bool with_residual, BodyAngles body) noexcept {
  const Floats<6> floats{reader};
  body.residual_m = read_residual(reader, with_residual);
  if (!floats.finite || !std::isfinite(body.residual_m)) return BodyAngles{};
  body.tracked = true;
  body.p_camera_body_m = metres(floats.value);
  if (!near(body.p_camera_body_m)) return kTooFar;
  for (std::size_t i = 0; i < 3; ++i) {
    if (std::abs(floats.value[3 + i]) > 360.0)
      return Fault{Reason::bad_value, "angle of a body beyond a full turn"};
    body.angles_rad[i] = floats.value[3 + i] * kRadiansPerDegree;
  }
  return body;
}

template <class Reader>
Result<Marker> read_item(Reader& reader, bool with_residual, Marker marker) noexcept {
  const Floats<3> floats{reader};
  marker.residual_m = read_residual(reader, with_residual);
  if (!floats.finite || !std::isfinite(marker.residual_m)) return Marker{};
  marker.tracked = true;
  marker.p_camera_marker_m = metres(floats.value);
  if (!near(marker.p_camera_marker_m)) return kTooFar;
  return marker;
}

/// The number of items that the component's head announces, once its size agrees.
/// @param stride  size of one item, bytes
template <class Reader>
Result<std::size_t> read_head(Reader& reader, std::size_t stride, std::size_t limit,
                              DataFrame& frame) noexcept {
  const std::size_t count = reader.template read<std::uint32_t>();
  const auto drop_per_mille = reader.template read<std::uint16_t>();
  const auto out_of_sync_per_mille = reader.template read<std::uint16_t>();
  if (!reader.ok()) return Fault{Reason::too_short, "component without a count"};
  if (count > limit) return Fault{Reason::too_long, "more bodies or markers than a frame of ours can hold"};
  if (reader.remaining() != count * stride)
    return Fault{Reason::bad_header, "size of a component does not fit its count"};
  frame.drop_rate = std::min(1e-3 * drop_per_mille, 1.0);
  frame.out_of_sync_rate = std::min(1e-3 * out_of_sync_per_mille, 1.0);
  return count;
}

template <class Reader, class T, std::size_t N>
Status read_items(Reader reader, std::size_t floats, bool with_residual, Items<T, N>& items,
                  DataFrame& frame) noexcept {
  const auto count = read_head(reader, sizeof(float) * (floats + (with_residual ? 1 : 0)), N, frame);
  if (!count) return count.fault();
  items.size = *count;
  for (std::size_t i = 0; i < *count; ++i) {
    const auto item = read_item(reader, with_residual, T{});
    if (!item) return item.fault();
    items.all[i] = *item;
  }
  return Done{};
}

template <class Reader>
Status read_unlabelled(Reader reader, bool with_residual, DataFrame& frame) noexcept {
  const auto count = read_head(reader, sizeof(float) * (with_residual ? 5 : 4), kMaxMarkers, frame);
  if (!count) return count.fault();
  frame.unlabelled.size = 0;
  for (std::size_t i = 0; i < *count; ++i) {
    const Floats<3> floats{reader};
    UnlabelledMarker marker;
    marker.id = reader.template read<std::uint32_t>();
    marker.residual_m = read_residual(reader, with_residual);
    if (!floats.finite || !std::isfinite(marker.residual_m)) continue;
    marker.p_camera_marker_m = metres(floats.value);
    if (!near(marker.p_camera_marker_m)) return kTooFar;
    frame.unlabelled.all[frame.unlabelled.size++] = marker;
  }
  return Done{};
}

/// The `width` bits of a word from bit `first` on.
std::uint32_t bits(std::uint32_t word, int first, int width) noexcept {
  return (word >> first) & ((1u << width) - 1u);
}

template <class Reader>
Status read_timecodes(Reader reader, DataFrame& frame) noexcept {
  const std::size_t count = reader.template read<std::uint32_t>();
  if (!reader.ok()) return Fault{Reason::too_short, "time code component without a count"};
  if (reader.remaining() / kTimecodeItemSize != count || reader.remaining() % kTimecodeItemSize != 0)
    return Fault{Reason::bad_header, "size of the time code component does not fit its count"};
  for (std::size_t i = 0; i < count; ++i) {
    const auto kind = static_cast<TimecodeKind>(reader.template read<std::uint32_t>());
    const auto high = reader.template read<std::uint32_t>();
    const auto low = reader.template read<std::uint32_t>();
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

/// @param reader  of the component behind its header
template <class Reader>
Status read_component(Component type, Reader reader, DataFrame& frame) noexcept {
  if (static_cast<std::uint32_t>(type) > static_cast<std::uint32_t>(Component::eye_tracker)) return Done{};
  if (frame.present.has(type))
    return Fault{Reason::bad_header, "the same component twice in one data packet"};
  frame.present.add(type);
  // Without residual it only fills in what the richer component has not given.
  switch (type) {
    case Component::bodies:
      if (frame.present.has(Component::bodies_res)) return Done{};
      [[fallthrough]];
    case Component::bodies_res:
      return read_items(reader, 12, type == Component::bodies_res, frame.bodies, frame);
    case Component::angles:
      if (frame.present.has(Component::angles_res)) return Done{};
      [[fallthrough]];
    case Component::angles_res:
      return read_items(reader, 6, type == Component::angles_res, frame.angles, frame);
    case Component::markers:
      if (frame.present.has(Component::markers_res)) return Done{};
      [[fallthrough]];
    case Component::markers_res:
      return read_items(reader, 3, type == Component::markers_res, frame.markers, frame);
    case Component::unlabelled:
      if (frame.present.has(Component::unlabelled_res)) return Done{};
      [[fallthrough]];
    case Component::unlabelled_res:
      return read_unlabelled(reader, type == Component::unlabelled_res, frame);
    case Component::timecode:
      return read_timecodes(reader, frame);
    default:
      return Done{};
  }
}

template <class Reader>
Result<DataFrame> decode(Bytes payload) noexcept {
  Reader reader{payload};
  DataFrame frame;
  frame.timestamp_us = reader.template read<std::uint64_t>();
  frame.frame_number = reader.template read<std::uint32_t>();
  const auto component_count = reader.template read<std::uint32_t>();
  if (!reader.ok()) return Fault{Reason::too_short, "data packet is shorter than its header"};
  if (frame.timestamp_us > kTimeLimit_ns / 1000)
    return Fault{Reason::bad_value, "frame time stamp beyond what can be"};

  for (std::uint32_t i = 0; i < component_count; ++i) {
    const std::size_t size = reader.template read<std::uint32_t>();
    const auto type = static_cast<Component>(reader.template read<std::uint32_t>());
    if (!reader.ok()) return Fault{Reason::too_short, "data packet has fewer components than it announces"};
    if (size < kComponentHeaderSize)
      return Fault{Reason::bad_header, "component announces fewer bytes than its own header has"};
    const Bytes body = reader.take(size - kComponentHeaderSize);
    if (!reader.ok()) return Fault{Reason::too_short, "component is longer than the data packet"};
    if (const Status status = read_component(type, Reader{body}, frame); !status) return status.fault();
  }
  if (reader.remaining() != 0) return Fault{Reason::too_long, "bytes behind the last component"};
  return frame;
}

}  // namespace

Result<DataFrame> decode_data(Bytes payload, std::endian order) noexcept {
  return order == std::endian::little ? decode<LittleReader>(payload) : decode<BigReader>(payload);
}

}  // namespace motionlab::qualisys
