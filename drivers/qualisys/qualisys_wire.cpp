#include "drivers/qualisys/qualisys_wire.hpp"

#include <algorithm>

namespace motionlab::qualisys {

namespace {

constexpr Fault kSizeBelowHeader{Reason::bad_header, "packet announces fewer bytes than its own header has"};
constexpr Fault kSizeAboveLimit{Reason::too_long,
                                "packet announces more bytes than this protocol ever sends"};

std::uint32_t load_word(Bytes from, std::endian order) noexcept {
  return order == std::endian::little ? load<std::uint32_t, std::endian::little>(from)
                                      : load<std::uint32_t, std::endian::big>(from);
}

void store_word(MutableBytes to, std::uint32_t word, std::endian order) noexcept {
  if (order == std::endian::little)
    store<std::endian::little>(to, word);
  else
    store<std::endian::big>(to, word);
}

ByteBuffer begin_packet(PacketType type, std::size_t payload_size, std::endian order) {
  ByteBuffer packet(kPacketHeaderSize + payload_size);
  store_word(packet, static_cast<std::uint32_t>(packet.size()), order);
  store_word(MutableBytes{packet}.subspan(4), static_cast<std::uint32_t>(type), order);
  return packet;
}

}  // namespace

Result<Packet> decode_datagram(Bytes datagram, std::endian order) noexcept {
  if (datagram.size() < kPacketHeaderSize)
    return Fault{Reason::too_short, "datagram is shorter than a packet header"};
  const std::size_t size = load_word(datagram, order);
  if (size < kPacketHeaderSize) return kSizeBelowHeader;
  if (size > datagram.size())
    return Fault{Reason::too_short, "datagram is shorter than its header announces"};
  if (size < datagram.size()) return Fault{Reason::too_long, "datagram is longer than its header announces"};
  return Packet{static_cast<PacketType>(load_word(datagram.subspan(4), order)),
                datagram.subspan(kPacketHeaderSize)};
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

ByteBuffer encode_text(PacketType type, std::string_view text, std::endian order) {
  ByteBuffer packet = begin_packet(type, text.size() + 1, order);
  std::copy(text.begin(), text.end(), packet.begin() + kPacketHeaderSize);
  return packet;
}

ByteBuffer encode_event(Event event, std::endian order) {
  ByteBuffer packet = begin_packet(PacketType::event, 1, order);
  packet.back() = static_cast<std::uint8_t>(event);
  return packet;
}

ByteBuffer encode_no_more_data(std::endian order) {
  return begin_packet(PacketType::no_more_data, 0, order);
}

void PacketSplitter::push(Bytes bytes) {
  buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(consumed_));
  consumed_ = 0;
  buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
}

std::optional<Result<Packet>> PacketSplitter::next() noexcept {
  const Bytes rest = Bytes{buffer_}.subspan(consumed_);
  if (rest.size() < sizeof(std::uint32_t)) return std::nullopt;
  const std::size_t size = load_word(rest, order_);
  if (size < kPacketHeaderSize) return Result<Packet>{kSizeBelowHeader};
  if (size > limit_) return Result<Packet>{kSizeAboveLimit};
  if (size > rest.size()) return std::nullopt;
  consumed_ += size;
  return Result<Packet>{Packet{static_cast<PacketType>(load_word(rest.subspan(4), order_)),
                               rest.subspan(kPacketHeaderSize, size - kPacketHeaderSize)}};
}

void PacketSplitter::reset() noexcept {
  buffer_.clear();
  consumed_ = 0;
}

}  // namespace motionlab::qualisys
