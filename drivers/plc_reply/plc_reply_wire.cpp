#include "drivers/plc_reply/plc_reply_wire.hpp"

#include <cmath>
#include <numbers>

namespace motionlab::plc_reply {
namespace {

constexpr double kPlaceMax_m = 10.0;
/// As the wire says it.
constexpr auto kTiltMax_rad = static_cast<double>(std::numbers::pi_v<float> / 2);
constexpr double kSpeedMax = 10.0;

/// Every number of a reply behind its mode, in the order of the wire.
void for_each_number(auto& reply, auto&& each) {
  const auto six = [&each](auto& values) {
    for (auto& value : values) each(value);
  };
  each(reply.t_s);
  six(reply.q_rad);
  six(reply.qd_radps);
  each(reply.wire_length_m);
  each(reply.wire_speed_mps);
  for (std::size_t ship = 0; ship < reply.platforms.size(); ++ship) {
    auto& platform = reply.platforms[ship];
    six(platform.eta);
    six(platform.eta_dot);
    six(platform.eta_ddot);
    six(reply.mrus[ship].eta);
    six(reply.mrus[ship].v);
  }
}

/// @param low, high  of the six, which are looked at
bool within(const Six& values, std::size_t low, std::size_t high, double limit) noexcept {
  return std::all_of(values.begin() + static_cast<std::ptrdiff_t>(low),
                     values.begin() + static_cast<std::ptrdiff_t>(high),
                     [limit](double value) { return std::abs(value) <= limit; });
}

bool possible_pose(const Six& eta) noexcept {
  return within(eta, 0, 3, kPlaceMax_m) && within(eta, 3, 5, kTiltMax_rad);
}

Fault wrong_size(bool too_short) noexcept {
  return {too_short ? Reason::too_short : Reason::too_long,
          "a reply has 304 bytes, a request 136: does another version of the program run on the PLC?"};
}

}  // namespace

Result<Request> decode_request(Bytes datagram) noexcept {
  if (datagram.size() != kRequestSize) return wrong_size(datagram.size() < kRequestSize);
  LittleReader reader{datagram};
  Request request;
  request.key = reader.read<std::uint32_t>();
  request.heartbeat = reader.read<std::uint32_t>();
  request.mode = reader.read<std::uint32_t>();
  for (float& value : request.wanted) value = reader.read<float>();
  return request;
}

Result<Reply> decode_reply(Bytes datagram) noexcept {
  if (datagram.size() != kReplySize) return wrong_size(datagram.size() < kReplySize);
  LittleReader reader{datagram};
  Reply reply;
  reply.mode = reader.read<std::uint32_t>();
  bool finite = true;
  for_each_number(reply, [&](double& value) {
    value = static_cast<double>(reader.read<float>());
    finite = finite && std::isfinite(value);
  });
  if (!finite) return Fault{Reason::bad_value, "a value of the reply is not finite"};
  for (const PlatformFeedback& platform : reply.platforms) {
    if (!possible_pose(platform.eta))
      return Fault{Reason::bad_value, "the reply puts a platform where none can be: compare its layout"};
  }
  for (const MruFeedback& unit : reply.mrus) {
    if (!possible_pose(unit.eta) || !within(unit.v, 0, 6, kSpeedMax))
      return Fault{Reason::bad_value, "the reply has a motion that no unit measures: compare its layout"};
  }
  return reply;
}

std::array<std::uint8_t, kReplySize> encode(const Reply& reply) noexcept {
  std::array<std::uint8_t, kReplySize> bytes{};
  LittleWriter writer{bytes};
  writer.write(reply.mode);
  for_each_number(reply, [&writer](double value) { writer.write(static_cast<float>(value)); });
  return bytes;
}

}  // namespace motionlab::plc_reply
