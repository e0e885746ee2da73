/// @file  The remote interface of the laboratory's PLC, to read from: one request, one reply.
///
/// Little-endian, fields of four bytes, no padding. Request, 136 bytes: u32 key · u32 heartbeat · u32 mode ·
/// f32[6] EM8000 position · f32[6] EM8000 velocity · f32[6] EM1500 position · f32[6] EM1500 velocity ·
/// f32[6] joint velocity · f32 wire speed. Reply, 304 bytes: u32 mode · f32 time · f32[6] joint position ·
/// f32[6] joint velocity · f32 wire length · f32 wire speed · EM8000 eta, its first and second derivative,
/// f32[6] each · MRU1 eta and v, f32[6] each · the same of EM1500 and MRU2. SI and radians already on the
/// wire. Source: the laboratory's published PLC project (remote interface, 2019).
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "drivers/core/bytes.hpp"
#include "drivers/core/result.hpp"

namespace motionlab::plc_reply {

inline constexpr std::size_t kRequestSize = 136;
inline constexpr std::size_t kReplySize = 304;

/// The one request that this house can make: nothing but zeros.
///
/// The PLC answers any 136 bytes. It hands control over only to who sends its key, 46505228, together with a
/// heartbeat that changes at least twice a second. Here the key is 0, the heartbeat stands still, and what
/// would command is 0 as well: three reasons, each enough by itself. There is no function that writes
/// another.
inline constexpr std::array<std::uint8_t, kRequestSize> kRequest{};
static_assert(std::ranges::all_of(kRequest, [](std::uint8_t byte) { return byte == 0; }));

/// What takes control; known here only so that the simulated PLC can tell who would have it.
inline constexpr std::uint32_t kControlKey = 46505228;

/// A request as the PLC reads it; what it says may be nonsense.
struct Request {
  std::uint32_t key = 0;
  std::uint32_t heartbeat = 0;
  std::uint32_t mode = 0;
  std::array<float, 31> wanted{};  ///< everything that commands, in the order of the wire
};

/// Three lengths, then three angles, or their derivatives: m, m/s, m/s²; rad, rad/s, rad/s².
using Six = std::array<double, 6>;

/// By the encoders of a platform's own legs: surge, sway, heave along the axes of its neutral frame N (z
/// down, heave + down, zero at neutral), then roll, pitch, yaw. Published code turns by R_NB = Rx(roll)
/// Ry(pitch) Rz(yaw).
struct PlatformFeedback {
  Six eta{}, eta_dot{}, eta_ddot{};

  bool operator==(const PlatformFeedback&) const = default;
};

/// Half of what a motion reference unit says, as the PLC last heard it. `eta`: high-passed position of the
/// platform's origin (forward, starboard, down; heading frame), then roll, pitch, yaw. `v`: its velocity,
/// likewise in the heading frame, then the rates of turn about the unit's own axes. So `v` is no twist.
struct MruFeedback {
  Six eta{}, v{};

  bool operator==(const MruFeedback&) const = default;
};

/// What the PLC says. The published program leaves the joints and the winch at zero, and the mode.
struct Reply {
  std::uint32_t mode = 0;
  double t_s = 0.0;  ///< 5 ms more in each of its cycles, as far as 24 bits can count them
  Six q_rad{}, qd_radps{};
  double wire_length_m = 0.0, wire_speed_mps = 0.0;
  std::array<PlatformFeedback, 2> platforms{};  ///< EM8000, EM1500
  std::array<MruFeedback, 2> mrus{};            ///< on EM8000, on EM1500

  bool operator==(const Reply&) const = default;
};

/// Reads a request by its size alone, as the PLC does. Faults: too_short, too_long.
[[nodiscard]] Result<Request> decode_request(Bytes datagram) noexcept;

/// Reads a reply. The size is its only mark, so what no platform does is refused: places beyond 10 m, roll
/// or pitch beyond a right angle, speeds of a unit beyond 10 m/s or 10 rad/s.
/// Faults: too_short, too_long, bad_value (not finite anywhere, or implausible). Never throws or allocates.
[[nodiscard]] Result<Reply> decode_reply(Bytes datagram) noexcept;

/// Writes the values as they are, NaN included: the simulated PLC must be able to lie.
[[nodiscard]] std::array<std::uint8_t, kReplySize> encode(const Reply& reply) noexcept;

}  // namespace motionlab::plc_reply
