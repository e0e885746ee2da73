#include "drivers/winch/winch_wire_notification.hpp"

namespace motionlab::winch {

namespace {
constexpr std::size_t kStreamHeaderSize = 8;  // length of what follows it, number of stamps
constexpr std::size_t kLengthFieldSize = 4;
}  // namespace

void NotificationStream::encode(LittleWriter& writer) const noexcept {
  std::size_t length = kStreamHeaderSize - kLengthFieldSize;
  for (const auto& stamp : stamps) {
    length += sizeof(stamp.filetime) + sizeof(std::uint32_t);
    for (const auto& sample : stamp.samples) length += 2 * sizeof(std::uint32_t) + sample.data.size();
  }
  writer.write(static_cast<std::uint32_t>(length));
  writer.write(static_cast<std::uint32_t>(stamps.size()));
  for (const auto& stamp : stamps) {
    writer.write(stamp.filetime);
    writer.write(static_cast<std::uint32_t>(stamp.samples.size()));
    for (const auto& sample : stamp.samples) {
      writer.write(sample.handle);
      writer.write(static_cast<std::uint32_t>(sample.data.size()));
      writer.write_bytes(sample.data);
    }
  }
}

NotificationReader::NotificationReader(Bytes data) noexcept : reader_(data) {
  reader_.skip(kLengthFieldSize);
  stamps_left_ = reader_.read<std::uint32_t>();
}

Result<NotificationReader> NotificationReader::open(Bytes data) noexcept {
  if (data.size() < kStreamHeaderSize)
    return Fault{Reason::too_short, "notification without a stream header"};
  if (load<std::uint32_t, std::endian::little>(data) != data.size() - kLengthFieldSize) {
    return Fault{Reason::bad_header, "the notification stream's length does not fit its frame"};
  }
  NotificationReader walk{data};
  while (walk.next()) {
  }
  if (!walk.ok()) return Fault{Reason::too_short, "notification stream ends inside a sample"};
  if (walk.reader_.remaining() > 0)
    return Fault{Reason::too_long, "bytes behind the last notification sample"};
  return NotificationReader{data};
}

std::optional<NotificationReader::Item> NotificationReader::next() noexcept {
  while (samples_left_ == 0) {
    if (stamps_left_ == 0) return std::nullopt;
    --stamps_left_;
    filetime_ = reader_.read<std::uint64_t>();
    samples_left_ = reader_.read<std::uint32_t>();
    if (!reader_.ok()) return std::nullopt;
  }
  --samples_left_;
  Item item;
  item.filetime = filetime_;
  item.sample.handle = reader_.read<std::uint32_t>();
  const auto size = reader_.read<std::uint32_t>();
  item.sample.data = reader_.take(size);
  if (!reader_.ok()) return std::nullopt;
  return item;
}

}  // namespace motionlab::winch
