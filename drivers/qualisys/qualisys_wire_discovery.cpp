#include "drivers/qualisys/qualisys_wire_discovery.hpp"

#include "drivers/qualisys/qualisys_wire.hpp"

namespace motionlab::qualisys {

namespace {

constexpr std::size_t kPortSize = sizeof(std::uint16_t);
constexpr std::size_t kQuestionSize = kPacketHeaderSize + kPortSize;

Result<Packet> packet_of(Bytes datagram, PacketType type) noexcept {
  const auto packet = decode_datagram(datagram);
  if (packet && packet->type != type)
    return Fault{Reason::bad_header, "datagram of another type than discovery has"};
  return packet;
}

Result<std::uint16_t> port_at_end(Bytes payload) noexcept {
  const auto port = load<std::uint16_t, std::endian::big>(payload.last(kPortSize));
  if (port == 0) return Fault{Reason::bad_value, "discovery with port 0"};
  return port;
}

void begin(LittleWriter& writer, std::size_t size, PacketType type) noexcept {
  writer.write(static_cast<std::uint32_t>(size));
  writer.write(static_cast<std::uint32_t>(type));
}

}  // namespace

Result<std::uint16_t> decode_discovery(Bytes datagram) noexcept {
  const auto packet = packet_of(datagram, PacketType::discover);
  if (!packet) return packet.fault();
  if (packet->payload.size() < kPortSize) return Fault{Reason::too_short, "discovery without a port"};
  if (packet->payload.size() > kPortSize) return Fault{Reason::too_long, "discovery with more than a port"};
  return port_at_end(packet->payload);
}

ByteBuffer encode_discovery(std::uint16_t answer_port) {
  ByteBuffer datagram(kQuestionSize);
  LittleWriter writer{datagram};
  begin(writer, kQuestionSize, PacketType::discover);
  store<std::endian::big>(MutableBytes{datagram}.last(kPortSize), answer_port);
  return datagram;
}

Result<DiscoveryAnswer> decode_discovery_answer(Bytes datagram) noexcept {
  const auto packet = packet_of(datagram, PacketType::command);
  if (!packet) return packet.fault();
  if (packet->payload.size() < 1 + kPortSize)
    return Fault{Reason::too_short, "discovery answer without text and port"};
  const std::string_view text = as_text(packet->payload.first(packet->payload.size() - kPortSize));
  if (text.find('\0') != text.size() - 1)
    return Fault{Reason::bad_header, "discovery answer whose text does not end before its port"};
  const auto port = port_at_end(packet->payload);
  if (!port) return port.fault();
  return DiscoveryAnswer{text.substr(0, text.size() - 1), *port};
}

ByteBuffer encode_discovery_answer(const DiscoveryAnswer& answer) {
  ByteBuffer datagram(kPacketHeaderSize + answer.info.size() + 1 + kPortSize);
  LittleWriter writer{datagram};
  begin(writer, datagram.size(), PacketType::command);
  writer.write_bytes(as_bytes(answer.info));
  store<std::endian::big>(MutableBytes{datagram}.last(kPortSize), answer.base_port);
  return datagram;
}

}  // namespace motionlab::qualisys
