#include <algorithm>
#include <cmath>
#include <numbers>

#include "drivers/qualisys/qualisys_wire.hpp"
#include "drivers/qualisys/qualisys_wire_data.hpp"
#include "drivers/qualisys/qualisys_wire_layout.hpp"
#include "drivers/qualisys/qualisys_wire_rotation.hpp"

namespace motionlab::qualisys {

namespace {

constexpr double kDegreesPerRadian = 180.0 / std::numbers::pi;

template <class Writer>
void write_position(Writer& writer, const std::array<double, 3>& p_m) noexcept {
  for (const double p : p_m) writer.write(static_cast<float>(p / kMetresPerMillimetre));
}

template <class Writer>
void write_measured(Writer& writer, const BodyPose& pose) noexcept {
  write_position(writer, pose.p_camera_body_m);
  const Matrix r = to_matrix(pose.q_camera_body);
  for (std::size_t k = 0; k < 9; ++k) writer.write(static_cast<float>(r[k % 3][k / 3]));
}

template <class Writer>
void write_measured(Writer& writer, const BodyAngles& body) noexcept {
  write_position(writer, body.p_camera_body_m);
  for (const double angle : body.angles_rad) writer.write(static_cast<float>(angle * kDegreesPerRadian));
}

template <class Writer>
void write_measured(Writer& writer, const Marker& marker) noexcept {
  write_position(writer, marker.p_camera_marker_m);
}

/// @param floats  of one item, without its residual
template <class Writer, class T>
void write_item(Writer& writer, const T& item, std::size_t floats, bool with_residual) noexcept {
  if (!item.tracked) {
    for (std::size_t i = 0; i < floats + (with_residual ? 1 : 0); ++i) writer.write(kLost);
    return;
  }
  write_measured(writer, item);
  if (with_residual) writer.write(static_cast<float>(item.residual_m / kMetresPerMillimetre));
}

template <class Writer>
void write_item(Writer& writer, const UnlabelledMarker& marker, std::size_t, bool with_residual) noexcept {
  write_position(writer, marker.p_camera_marker_m);
  writer.write(marker.id);
  if (with_residual) writer.write(static_cast<float>(marker.residual_m / kMetresPerMillimetre));
}

std::uint16_t per_mille(double rate) noexcept {
  return static_cast<std::uint16_t>(std::lround(std::clamp(rate, 0.0, 1.0) * 1000.0));
}

template <class Writer, class T>
void write_items(Writer& writer, Component type, const DataFrame& frame, std::span<const T> items,
                 std::size_t floats, bool with_residual) noexcept {
  const std::size_t stride = sizeof(float) * (floats + (with_residual ? 1 : 0));
  writer.write(static_cast<std::uint32_t>(kComponentHeaderSize + kItemsHeadSize + stride * items.size()));
  writer.write(static_cast<std::uint32_t>(type));
  writer.write(static_cast<std::uint32_t>(items.size()));
  writer.write(per_mille(frame.drop_rate));
  writer.write(per_mille(frame.out_of_sync_rate));
  for (const T& item : items) write_item(writer, item, floats, with_residual);
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

template <class Writer>
void write_timecode(Writer& writer, const Timecode& timecode) noexcept {
  const TimecodeWords words = std::visit([](const auto& t) { return to_words(t); }, timecode);
  writer.write(static_cast<std::uint32_t>(kComponentHeaderSize + sizeof(std::uint32_t) + kTimecodeItemSize));
  writer.write(static_cast<std::uint32_t>(Component::timecode));
  writer.write(std::uint32_t{1});
  writer.write(static_cast<std::uint32_t>(words.kind));
  writer.write(words.high);
  writer.write(words.low);
}

/// @returns false for a component that this codec has no layout of, or that the frame does not have
template <class Writer>
bool write_component(Writer& writer, Component type, const DataFrame& frame) noexcept {
  switch (type) {
    case Component::bodies:
    case Component::bodies_res:
      write_items(writer, type, frame, frame.bodies.view(), 12, type == Component::bodies_res);
      return true;
    case Component::angles:
    case Component::angles_res:
      write_items(writer, type, frame, frame.angles.view(), 6, type == Component::angles_res);
      return true;
    case Component::markers:
    case Component::markers_res:
      write_items(writer, type, frame, frame.markers.view(), 3, type == Component::markers_res);
      return true;
    case Component::unlabelled:
    case Component::unlabelled_res:
      write_items(writer, type, frame, frame.unlabelled.view(), 4, type == Component::unlabelled_res);
      return true;
    case Component::timecode:
      if (!frame.timecode) return false;
      write_timecode(writer, *frame.timecode);
      return true;
    default:
      return false;
  }
}

template <std::endian Order>
Result<Bytes> encode(const DataFrame& frame, const Components& components, MutableBytes out) noexcept {
  constexpr std::size_t kCountAt = 20;
  Writer<Order> writer{out};
  writer.write(std::uint32_t{0});  // the size, known at the end
  writer.write(static_cast<std::uint32_t>(PacketType::data));
  writer.write(frame.timestamp_us);
  writer.write(frame.frame_number);
  writer.write(std::uint32_t{0});  // the number of components likewise
  std::uint32_t count = 0;
  for (std::uint32_t type = 1; type <= static_cast<std::uint32_t>(Component::eye_tracker); ++type) {
    const auto component = static_cast<Component>(type);
    if (components.has(component) && write_component(writer, component, frame)) ++count;
  }
  if (!writer.ok()) return Fault{Reason::too_long, "data packet does not fit the buffer"};
  store<Order>(out, static_cast<std::uint32_t>(writer.position()));
  store<Order>(out.subspan(kCountAt), count);
  return writer.written();
}

}  // namespace

Result<Bytes> encode_data(const DataFrame& frame, const Components& components, MutableBytes out,
                          std::endian order) noexcept {
  return order == std::endian::little ? encode<std::endian::little>(frame, components, out)
                                      : encode<std::endian::big>(frame, components, out);
}

}  // namespace motionlab::qualisys
