#include "drivers/mru/mru_wire.hpp"

#include <cmath>

namespace motionlab::mru {

Status check_plausible(const VariableFacts& facts, double value, const PlausibilityLimits& limits) noexcept {
  if (!std::isfinite(value)) {
    return Fault{Reason::bad_value, "a value is not finite: the unit is faulty or the datagram is damaged"};
  }
  const double magnitude = std::abs(value);
  switch (facts.quantity) {
    case Quantity::tilt:
      if (magnitude > limits.tilt_rad) {
        return Fault{Reason::bad_value, "roll or pitch is beyond its limit: check units and variable list"};
      }
      break;
    case Quantity::heave:
      if (magnitude > limits.heave_m) {
        return Fault{Reason::bad_value, "heave is beyond its limit: check units and variable list"};
      }
      break;
    case Quantity::rate:
      if (magnitude > limits.rate_radps) {
        return Fault{Reason::bad_value, "a rate of turn is beyond its limit: check units and variable list"};
      }
      break;
    case Quantity::time:
    case Quantity::temperature:
    case Quantity::heading:
    case Quantity::motion:
    case Quantity::unlisted:
      break;
  }
  return Done{};
}

std::uint8_t checksum(ChecksumRule rule, Bytes token_and_data) noexcept {
  std::uint32_t sum = 0;
  for (const std::uint8_t byte : token_and_data) sum += byte;
  if (rule == ChecksumRule::sum8) return static_cast<std::uint8_t>(sum);
  while (sum > 0xFF) sum = (sum & 0xFF) + (sum >> 8);
  return static_cast<std::uint8_t>(~sum);
}

std::optional<double> Frame::value(Variable variable, const Layout& layout) const noexcept {
  const auto index = layout.variables.index_of(variable);
  if (!index || *index >= size) return std::nullopt;
  return values[*index];
}

std::optional<std::uint32_t> Frame::system_time_ms(const Layout& layout) const noexcept {
  const auto ms = value(Variable::system_time, layout);
  if (!ms) return std::nullopt;
  return static_cast<std::uint32_t>(static_cast<std::int64_t>(*ms));
}

Result<Frame> decode(Bytes datagram, const Layout& layout) noexcept {
  if (datagram.size() < kOverhead) {
    return Fault{Reason::too_short, "shorter than header, length, token and checksum"};
  }
  BigReader reader{datagram};
  const auto header = reader.read<std::uint8_t>();
  const auto length = reader.read<std::uint8_t>();
  const auto token = reader.read<std::uint8_t>();
  if (header != kStableHeader && header != kUnstableHeader) {
    return Fault{Reason::bad_header, "the first byte is neither q nor Q: the port does not carry MRUBIN"};
  }
  if (length % 4 != 1) return Fault{Reason::bad_header, "the length byte is not 1 + 4 N"};
  const std::size_t announced = std::size_t{length} + 3;
  if (datagram.size() < announced) return Fault{Reason::too_short, "fewer bytes than the length byte says"};
  if (datagram.size() > announced) return Fault{Reason::too_long, "more bytes than the length byte says"};
  if (token != layout.token) {
    return Fault{Reason::bad_header,
                 "another token: is this the port of the other unit? See the token setting"};
  }
  if (announced != layout.datagram_size()) {
    return Fault{Reason::bad_header,
                 "another number of variables: compare the unit's list with the configured one"};
  }

  Frame frame;
  frame.stable = header == kStableHeader;
  frame.token = token;
  frame.size = layout.variables.size();
  for (std::size_t i = 0; i < frame.size; ++i) {
    const VariableFacts& facts = layout.variables[i];
    const double value = facts.type == ValueType::f32 ? static_cast<double>(reader.read<float>())
                                                      : static_cast<double>(reader.read<std::int32_t>());
    if (const Status plausible = check_plausible(facts, value, layout.limits); !plausible) {
      return plausible.fault();
    }
    frame.values[i] = value;
  }
  frame.checksum = reader.read<std::uint8_t>();
  const Bytes summed = datagram.subspan(2, length);
  const std::uint8_t inverted = checksum(ChecksumRule::ones_complement, summed);
  const bool both_zero =
      (frame.checksum == 0x00 || frame.checksum == 0xFF) && (inverted == 0x00 || inverted == 0xFF);
  frame.checksum_match.sum8 = frame.checksum == checksum(ChecksumRule::sum8, summed);
  frame.checksum_match.ones_complement = frame.checksum == inverted || both_zero;
  return frame;
}

Result<Bytes> encode(const Frame& frame, const Layout& layout, ChecksumRule rule, MutableBytes to) noexcept {
  const std::size_t size = layout.datagram_size();
  if (to.size() < size) return Fault{Reason::too_short, "no room for the datagram"};
  BigWriter writer{to.first(size)};
  writer.write(frame.stable ? kStableHeader : kUnstableHeader);
  writer.write(static_cast<std::uint8_t>(size - 3));
  writer.write(layout.token);
  for (std::size_t i = 0; i < layout.variables.size(); ++i) {
    const double value = frame.values[i];
    if (layout.variables[i].type == ValueType::f32) {
      writer.write(static_cast<float>(value));
    } else {
      // Counters run modulo 2^32; anything beyond int64 could not be cast.
      if (!(std::abs(value) < 0x1p62)) return Fault{Reason::bad_value, "an integer variable is not finite"};
      writer.write(static_cast<std::uint32_t>(static_cast<std::int64_t>(value)));
    }
  }
  writer.write(checksum(rule, to.subspan(2, size - 3)));
  return Bytes{to.first(size)};
}

}  // namespace motionlab::mru
