#include "drivers/winch/winch_wire_ams.hpp"

#include <charconv>

#include "drivers/core/error.hpp"

namespace motionlab::winch {

namespace {

constexpr std::size_t kLocalBodyMax = 64;  // port connect and its kin carry a few bytes
constexpr std::size_t kBufferAtBirth = 16 * 1024;

AmsAddress read_address(LittleReader& reader) noexcept {
  AmsAddress address;
  for (auto& number : address.net_id.numbers) number = reader.read<std::uint8_t>();
  address.port = reader.read<std::uint16_t>();
  return address;
}

void write_address(LittleWriter& writer, const AmsAddress& address) noexcept {
  writer.write_bytes(address.net_id.numbers);
  writer.write(address.port);
}

bool known(TcpCommand command) noexcept {
  switch (command) {
    case TcpCommand::ads:
    case TcpCommand::port_close:
    case TcpCommand::port_connect:
    case TcpCommand::router_note:
    case TcpCommand::local_net_id:
      return true;
  }
  return false;
}

std::optional<Fault> check(TcpCommand command, std::size_t length, std::size_t body_max) noexcept {
  if (!known(command)) return Fault{Reason::bad_header, "unknown AMS/TCP command: is this an ADS port?"};
  if (command == TcpCommand::ads && length < kAmsHeaderSize) {
    return Fault{Reason::too_short, "AMS/TCP length is shorter than an AMS header"};
  }
  if (length > (command == TcpCommand::ads ? body_max : kLocalBodyMax)) {
    return Fault{Reason::too_long, "AMS/TCP length is longer than any frame we expect"};
  }
  return std::nullopt;
}

}  // namespace

NetId NetId::parse(std::string_view text) {
  const auto refuse = [&] {
    std::string message{text};
    message += " is not an AMS NetId; write six numbers 0..255, for example 192.168.90.150.1.1";
    return StartupError(message);
  };
  NetId net_id;
  const char* at = text.data();
  const char* const end = text.data() + text.size();
  for (std::size_t i = 0; i < net_id.numbers.size(); ++i) {
    if (i > 0) {
      if (at == end || *at != '.') throw refuse();
      ++at;
    }
    const auto [next, error] = std::from_chars(at, end, net_id.numbers[i]);
    if (error != std::errc{}) throw refuse();
    at = next;
  }
  if (at != end) throw refuse();
  return net_id;
}

std::string to_string(const NetId& net_id) {
  std::string text;
  for (const auto number : net_id.numbers) {
    if (!text.empty()) text += '.';
    text += std::to_string(number);
  }
  return text;
}

Result<AmsFrame> decode_ams(Bytes body) noexcept {
  LittleReader reader{body};
  AmsFrame frame;
  frame.header.target = read_address(reader);
  frame.header.source = read_address(reader);
  frame.header.command = reader.read<std::uint16_t>();
  frame.header.flags = reader.read<std::uint16_t>();
  const auto length = reader.read<std::uint32_t>();
  frame.header.error = reader.read<std::uint32_t>();
  frame.header.invoke_id = reader.read<std::uint32_t>();
  if (!reader.ok()) return Fault{Reason::too_short, "shorter than an AMS header"};
  if (length > reader.remaining())
    return Fault{Reason::too_short, "AMS length says more than the frame holds"};
  if (length < reader.remaining())
    return Fault{Reason::too_long, "AMS length says less than the frame holds"};
  frame.data = reader.take(length);
  return frame;
}

Result<Bytes> encode_tcp_frame(MutableBytes to, TcpCommand command, Bytes body) noexcept {
  LittleWriter writer{to};
  writer.write(static_cast<std::uint16_t>(command));
  writer.write(static_cast<std::uint32_t>(body.size()));
  writer.write_bytes(body);
  if (!writer.ok()) return Fault{Reason::too_long, "the message does not fit into the frame buffer"};
  return writer.written();
}

namespace detail {

void begin_frame(LittleWriter& writer, const AmsHeader& header) noexcept {
  writer.write(static_cast<std::uint16_t>(TcpCommand::ads));
  writer.write(std::uint32_t{0});
  write_address(writer, header.target);
  write_address(writer, header.source);
  writer.write(header.command);
  writer.write(header.flags);
  writer.write(std::uint32_t{0});
  writer.write(header.error);
  writer.write(header.invoke_id);
}

void finish_frame(MutableBytes frame) noexcept {
  constexpr std::size_t kTcpLengthAt = 2;
  constexpr std::size_t kAmsLengthAt = kTcpHeaderSize + 20;
  const auto body = static_cast<std::uint32_t>(frame.size() - kTcpHeaderSize);
  const auto data = static_cast<std::uint32_t>(frame.size() - kFrameHeaderSize);
  store<std::endian::little>(frame.subspan(kTcpLengthAt), body);
  store<std::endian::little>(frame.subspan(kAmsLengthAt), data);
}

}  // namespace detail

FrameSplitter::FrameSplitter(std::size_t body_max) : body_max_(body_max) {
  buffer_.reserve(kBufferAtBirth);
}

void FrameSplitter::append(Bytes bytes) {
  if (fault_) return;
  buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(begin_));
  begin_ = 0;
  buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
}

Result<std::optional<TcpFrame>> FrameSplitter::next() noexcept {
  if (fault_) return *fault_;
  const Bytes rest = Bytes{buffer_}.subspan(begin_);
  if (rest.size() < kTcpHeaderSize) return std::optional<TcpFrame>{};
  LittleReader reader{rest};
  const auto command = static_cast<TcpCommand>(reader.read<std::uint16_t>());
  const std::size_t length = reader.read<std::uint32_t>();
  fault_ = check(command, length, body_max_);
  if (fault_) return *fault_;
  if (reader.remaining() < length) return std::optional<TcpFrame>{};
  begin_ += kTcpHeaderSize + length;
  return std::optional{TcpFrame{command, reader.take(length)}};
}

void FrameSplitter::reset() noexcept {
  buffer_.clear();
  begin_ = 0;
  fault_.reset();
}

}  // namespace motionlab::winch
