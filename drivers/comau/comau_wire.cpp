#include "drivers/comau/comau_wire.hpp"

#include <algorithm>
#include <cmath>

namespace motionlab::comau {
namespace {

Joints read_joints(LittleReader& reader) noexcept {
  Joints joints;
  for (double& value : joints) value = static_cast<double>(reader.read<float>());
  return joints;
}

void write_joints(LittleWriter& writer, const Joints& joints) noexcept {
  for (const double value : joints) writer.write(static_cast<float>(value));
}

bool all_finite(const auto& values) noexcept {
  return std::ranges::all_of(values, [](auto value) { return std::isfinite(value); });
}

}  // namespace

Result<Command> decode_command(Bytes datagram) noexcept {
  if (datagram.size() < kCommandSize)
    return Fault{Reason::too_short, "a command has 32 bytes; this has fewer"};
  if (datagram.size() > kCommandSize) return Fault{Reason::too_long, "a command has 32 bytes; this has more"};
  LittleReader reader{datagram};
  Command command;
  command.key = reader.read<std::int32_t>();
  command.mode = reader.read<std::int32_t>();
  for (float& value : command.qd_radps) value = reader.read<float>();
  return command;
}

Status check(const Command& command) noexcept {
  if (command.key != kKey) return Fault{Reason::bad_header, "the key is not 32: not a command"};
  if (command.mode != static_cast<std::int32_t>(Mode::hold) &&
      command.mode != static_cast<std::int32_t>(Mode::follow)) {
    return Fault{Reason::bad_header, "the mode is neither 0 (hold) nor 1 (follow)"};
  }
  if (!all_finite(command.qd_radps)) return Fault{Reason::bad_value, "a wanted velocity is not finite"};
  return Done{};
}

Result<Answer> decode_answer(Bytes datagram) noexcept {
  if (datagram.size() < kAnswerSize) {
    return Fault{Reason::too_short,
                 "an answer has 52 or 124 bytes; this has fewer: which program runs on the robot computer?"};
  }
  const bool long_form = datagram.size() == kLongAnswerSize;
  if (datagram.size() > kAnswerSize && !long_form) {
    return Fault{Reason::too_long,
                 "an answer has 52 or 124 bytes; this has another size: which program runs on the robot "
                 "computer?"};
  }
  LittleReader reader{datagram};
  Answer answer;
  answer.frame_counter = reader.read<std::uint32_t>();
  answer.q_rad = read_joints(reader);
  answer.qd_radps = read_joints(reader);
  if (!all_finite(answer.q_rad) || !all_finite(answer.qd_radps)) {
    return Fault{Reason::bad_value, "a joint value of the answer is not finite"};
  }
  if (!long_form) return answer;
  ReportedLimits limits;
  limits.q_min_rad = read_joints(reader);
  limits.q_max_rad = read_joints(reader);
  limits.qd_max_radps = read_joints(reader);
  if (!all_finite(limits.q_min_rad) || !all_finite(limits.q_max_rad) || !all_finite(limits.qd_max_radps)) {
    return Fault{Reason::bad_value, "a limit of the answer is not finite"};
  }
  answer.limits = limits;
  return answer;
}

std::array<std::uint8_t, kCommandSize> encode(const Command& command) noexcept {
  std::array<std::uint8_t, kCommandSize> bytes{};
  LittleWriter writer{bytes};
  writer.write(command.key);
  writer.write(command.mode);
  for (const float value : command.qd_radps) writer.write(value);
  return bytes;
}

AnswerBytes::AnswerBytes(const Answer& answer) noexcept
    : size_(answer.limits ? kLongAnswerSize : kAnswerSize) {
  LittleWriter writer{bytes_};
  writer.write(answer.frame_counter);
  write_joints(writer, answer.q_rad);
  write_joints(writer, answer.qd_radps);
  if (!answer.limits) return;
  write_joints(writer, answer.limits->q_min_rad);
  write_joints(writer, answer.limits->q_max_rad);
  write_joints(writer, answer.limits->qd_max_radps);
}

}  // namespace motionlab::comau
