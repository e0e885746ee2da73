#include "drivers/qualisys/qualisys_wire.hpp"

#include <algorithm>

namespace motionlab::qualisys {

namespace {

constexpr Fault kSizeBelowHeader{Reason::bad_header, "packet announces fewer bytes than its own header has"};
constexpr Fault kSizeAboveLimit{Reason::too_long,
                                "packet announces more bytes than this protocol ever sends"};

ByteBuffer begin_packet(PacketType type, std::size_t payload_size) {
  ByteBuffer packet(kPacketHeaderSize + payload_size);
  LittleWriter writer{packet};
  writer.write(static_cast<std::uint32_t>(packet.size()));
  writer.write(static_cast<std::uint32_t>(type));
  return packet;
}

}  // namespace

Result<Packet> decode_datagram(Bytes datagram) noexcept {
  LittleReader reader{datagram};
  const std::size_t size = reader.read<std::uint32_t>();
  const auto type = static_cast<PacketType>(reader.read<std::uint32_t>());
  if (!reader.ok()) return Fault{Reason::too_short, "datagram is shorter than a packet header"};
  if (size < kPacketHeaderSize) return kSizeBelowHeader;
  if (size > datagram.size())
    return Fault{Reason::too_short, "datagram is shorter than its header announces"};
  if (size < datagram.size()) return Fault{Reason::too_long, "datagram is longer than its header announces"};
  return Packet{type, reader.take(reader.remaining())};
}

std::string_view packet_text(Bytes payload) noexcept {
  const std::string_view text = as_text(payload);
  return text.substr(0, text.find('\0'));
}

Result<Event> decode_event(Bytes payload) noexcept {
  if (payload.empty()) return Fault{Reason::too_short, "event packet without an event number"};
  if (payload.size() > 1) return Fault{Reason::too_long, "event packet of more than one byte"};
  return static_cast<Event>(payload[0]);
}

ByteBuffer encode_text(PacketType type, std::string_view text) {
  ByteBuffer packet = begin_packet(type, text.size() + 1);
  std::copy(text.begin(), text.end(), packet.begin() + kPacketHeaderSize);
  return packet;
}

ByteBuffer encode_event(Event event) {
  ByteBuffer packet = begin_packet(PacketType::event, 1);
  packet.back() = static_cast<std::uint8_t>(event);
  return packet;
}

ByteBuffer encode_no_more_data() {
  return begin_packet(PacketType::no_more_data, 0);
}

void PacketSplitter::push(Bytes bytes) {
  buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(consumed_));
  consumed_ = 0;
  buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
}

std::optional<Result<Packet>> PacketSplitter::next() noexcept {
  const Bytes rest = Bytes{buffer_}.subspan(consumed_);
  LittleReader reader{rest};
  const std::size_t size = reader.read<std::uint32_t>();
  if (!reader.ok()) return std::nullopt;
  if (size < kPacketHeaderSize) return Result<Packet>{kSizeBelowHeader};
  if (size > limit_) return Result<Packet>{kSizeAboveLimit};
  if (size > rest.size()) return std::nullopt;
  const auto type = static_cast<PacketType>(reader.read<std::uint32_t>());
  consumed_ += size;
  return Result<Packet>{Packet{type, reader.take(size - kPacketHeaderSize)}};
}

void PacketSplitter::reset() noexcept {
  buffer_.clear();
  consumed_ = 0;
}

}  // namespace motionlab::qualisys
