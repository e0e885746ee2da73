/// @file  The laboratory's UDP exchange with the robot computer: bytes to numbers and back.
///
/// Little-endian, fields of four bytes, no padding. Command, 32 bytes: i32 key = 32 · i32 mode · f32[6] joint
/// velocity. Answer, 52 bytes: i32 frame counter · f32[6] position · f32[6] velocity; or 124 bytes: the same,
/// then the robot computer's own limits, f32[6] minimum position · f32[6] maximum position · f32[6] maximum
/// speed. Joint values are Comau's (joint 3 against the vertical, joint 1 clockwise), rad and rad/s. Sources:
/// the laboratory's published robot program, October 2019 (command, 52 bytes), and its published PLC project,
/// November 2019 (124 bytes).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "drivers/core/bytes.hpp"
#include "drivers/core/result.hpp"

namespace motionlab::comau {

inline constexpr std::size_t kJointCount = 6;
using Joints = std::array<double, kJointCount>;

inline constexpr std::size_t kCommandSize = 32;
inline constexpr std::size_t kAnswerSize = 52;
inline constexpr std::size_t kLongAnswerSize = 124;  ///< with the robot computer's limits
inline constexpr std::int32_t kKey = 32;
/// The robot computer runs its control callback, and counts it, once in this time.
inline constexpr double kCycleSeconds = 0.0004;

/// What the mode field asks for. Any number but 1 means hold.
enum class Mode : std::int32_t {
  hold = 0,    ///< the set point is taken from where the arm is, in every cycle, at once
  follow = 1,  ///< the set point is the integral of the wanted velocity
};

/// Wanted velocities exactly as they lie on the wire; nothing is checked (see `check`).
struct Command {
  std::int32_t key = kKey;
  std::int32_t mode = static_cast<std::int32_t>(Mode::hold);
  std::array<float, kJointCount> qd_radps{};

  bool operator==(const Command&) const = default;
};

/// The box and the speeds that the robot computer itself keeps the arm in.
struct ReportedLimits {
  Joints q_min_rad{};
  Joints q_max_rad{};
  Joints qd_max_radps{};

  bool operator==(const ReportedLimits&) const = default;
};

/// What the robot computer says of itself.
struct Answer {
  std::uint32_t frame_counter = 0;  ///< +1 per control cycle, modulo 2^32; the wire calls it signed
  Joints q_rad{};
  Joints qd_radps{};
  std::optional<ReportedLimits> limits{};  ///< of the long form alone
};

/// The bytes of one answer, of either form; a range, so that a span can be taken of it.
class AnswerBytes {
 public:
  explicit AnswerBytes(const Answer& answer) noexcept;
  [[nodiscard]] const std::uint8_t* begin() const noexcept { return bytes_.data(); }
  [[nodiscard]] const std::uint8_t* end() const noexcept { return bytes_.data() + size_; }
  [[nodiscard]] std::size_t size() const noexcept { return size_; }

 private:
  std::array<std::uint8_t, kLongAnswerSize> bytes_{};
  std::size_t size_ = kAnswerSize;
};

/// Reads a command by its size alone: what it says may be nonsense. Faults: too_short, too_long.
[[nodiscard]] Result<Command> decode_command(Bytes datagram) noexcept;

/// What a careful robot computer asks of a command: key, mode 0 or 1, finite velocities.
/// Faults: bad_header (key, mode), bad_value (not finite).
[[nodiscard]] Status check(const Command& command) noexcept;

/// Reads an answer; its form is told by its size, there is no other mark. Faults: too_short, too_long (no
/// form has that size: too long is what exceeds the short form), bad_value (not finite).
[[nodiscard]] Result<Answer> decode_answer(Bytes datagram) noexcept;

[[nodiscard]] std::array<std::uint8_t, kCommandSize> encode(const Command& command) noexcept;
/// Writes the long form if the answer has limits. The values are written as they are, NaN included: the
/// simulated robot computer must be able to lie.
[[nodiscard]] inline AnswerBytes encode(const Answer& answer) noexcept {
  return AnswerBytes{answer};
}

}  // namespace motionlab::comau
