#include "drivers/winch/winch_wire_ads.hpp"

namespace motionlab::winch {

namespace {

constexpr Fault kTooShort{Reason::too_short, "ADS data shorter than the command's layout"};
constexpr Fault kTooLong{Reason::too_long, "ADS data longer than the command's layout"};
constexpr std::size_t kReservedOfAddNotification = 16;
constexpr Nanoseconds kTick{100};  // the wire counts 100 ns

/// The message if every byte was used and none was missing.
template <class Message>
Result<Message> all_of(const LittleReader& reader, const Message& message) noexcept {
  if (!reader.ok()) return kTooShort;
  if (reader.remaining() > 0) return kTooLong;
  return message;
}

/// Likewise for a response: an error result may stand alone.
template <class Message>
Result<Message> all_of_response(const LittleReader& reader, const Message& message,
                                std::size_t size) noexcept {
  if (size == sizeof(std::uint32_t) && message.result != 0) {
    Message bare{};
    bare.result = message.result;
    return bare;
  }
  return all_of(reader, message);
}

std::uint32_t size_of(Bytes bytes) noexcept {
  return static_cast<std::uint32_t>(bytes.size());
}

}  // namespace

void ReadRequest::encode(LittleWriter& writer) const noexcept {
  writer.write(index_group);
  writer.write(index_offset);
  writer.write(length);
}

Result<ReadRequest> ReadRequest::decode(Bytes data) noexcept {
  LittleReader reader{data};
  ReadRequest request;
  request.index_group = reader.read<std::uint32_t>();
  request.index_offset = reader.read<std::uint32_t>();
  request.length = reader.read<std::uint32_t>();
  return all_of(reader, request);
}

void WriteRequest::encode(LittleWriter& writer) const noexcept {
  writer.write(index_group);
  writer.write(index_offset);
  writer.write(size_of(data));
  writer.write_bytes(data);
}

Result<WriteRequest> WriteRequest::decode(Bytes bytes) noexcept {
  LittleReader reader{bytes};
  WriteRequest request;
  request.index_group = reader.read<std::uint32_t>();
  request.index_offset = reader.read<std::uint32_t>();
  const auto length = reader.read<std::uint32_t>();
  request.data = reader.take(length);
  return all_of(reader, request);
}

void ReadWriteRequest::encode(LittleWriter& writer) const noexcept {
  writer.write(index_group);
  writer.write(index_offset);
  writer.write(read_length);
  writer.write(size_of(data));
  writer.write_bytes(data);
}

Result<ReadWriteRequest> ReadWriteRequest::decode(Bytes bytes) noexcept {
  LittleReader reader{bytes};
  ReadWriteRequest request;
  request.index_group = reader.read<std::uint32_t>();
  request.index_offset = reader.read<std::uint32_t>();
  request.read_length = reader.read<std::uint32_t>();
  const auto length = reader.read<std::uint32_t>();
  request.data = reader.take(length);
  return all_of(reader, request);
}

void WriteControlRequest::encode(LittleWriter& writer) const noexcept {
  writer.write(static_cast<std::uint16_t>(ads_state));
  writer.write(device_state);
  writer.write(size_of(data));
  writer.write_bytes(data);
}

Result<WriteControlRequest> WriteControlRequest::decode(Bytes bytes) noexcept {
  LittleReader reader{bytes};
  WriteControlRequest request;
  request.ads_state = static_cast<AdsState>(reader.read<std::uint16_t>());
  request.device_state = reader.read<std::uint16_t>();
  const auto length = reader.read<std::uint32_t>();
  request.data = reader.take(length);
  return all_of(reader, request);
}

void AddNotificationRequest::encode(LittleWriter& writer) const noexcept {
  writer.write(index_group);
  writer.write(index_offset);
  writer.write(length);
  writer.write(mode);
  writer.write(static_cast<std::uint32_t>(max_delay / kTick));
  writer.write(static_cast<std::uint32_t>(cycle_time / kTick));
  for (std::size_t i = 0; i < kReservedOfAddNotification; ++i) writer.write(std::uint8_t{0});
}

Result<AddNotificationRequest> AddNotificationRequest::decode(Bytes data) noexcept {
  LittleReader reader{data};
  AddNotificationRequest request;
  request.index_group = reader.read<std::uint32_t>();
  request.index_offset = reader.read<std::uint32_t>();
  request.length = reader.read<std::uint32_t>();
  request.mode = reader.read<std::uint32_t>();
  request.max_delay = kTick * reader.read<std::uint32_t>();
  request.cycle_time = kTick * reader.read<std::uint32_t>();
  reader.skip(kReservedOfAddNotification);
  return all_of(reader, request);
}

void DeleteNotificationRequest::encode(LittleWriter& writer) const noexcept {
  writer.write(handle);
}

Result<DeleteNotificationRequest> DeleteNotificationRequest::decode(Bytes data) noexcept {
  LittleReader reader{data};
  const DeleteNotificationRequest request{reader.read<std::uint32_t>()};
  return all_of(reader, request);
}

void ResultResponse::encode(LittleWriter& writer) const noexcept {
  writer.write(result);
}

Result<ResultResponse> ResultResponse::decode(Bytes data) noexcept {
  LittleReader reader{data};
  const ResultResponse response{reader.read<std::uint32_t>()};
  return all_of(reader, response);
}

void ReadResponse::encode(LittleWriter& writer) const noexcept {
  writer.write(result);
  writer.write(size_of(data));
  writer.write_bytes(data);
}

Result<ReadResponse> ReadResponse::decode(Bytes bytes) noexcept {
  LittleReader reader{bytes};
  ReadResponse response;
  response.result = reader.read<std::uint32_t>();
  const auto length = reader.read<std::uint32_t>();
  response.data = reader.take(length);
  return all_of_response(reader, response, bytes.size());
}

void ReadStateResponse::encode(LittleWriter& writer) const noexcept {
  writer.write(result);
  writer.write(static_cast<std::uint16_t>(ads_state));
  writer.write(device_state);
}

Result<ReadStateResponse> ReadStateResponse::decode(Bytes data) noexcept {
  LittleReader reader{data};
  ReadStateResponse response;
  response.result = reader.read<std::uint32_t>();
  response.ads_state = static_cast<AdsState>(reader.read<std::uint16_t>());
  response.device_state = reader.read<std::uint16_t>();
  return all_of_response(reader, response, data.size());
}

void DeviceInfoResponse::encode(LittleWriter& writer) const noexcept {
  writer.write(result);
  writer.write(major);
  writer.write(minor);
  writer.write(build);
  writer.write_bytes(as_bytes(name.view()));
  for (std::size_t i = name.view().size(); i < name.kCapacity; ++i) writer.write(std::uint8_t{0});
}

Result<DeviceInfoResponse> DeviceInfoResponse::decode(Bytes data) noexcept {
  LittleReader reader{data};
  DeviceInfoResponse response;
  response.result = reader.read<std::uint32_t>();
  response.major = reader.read<std::uint8_t>();
  response.minor = reader.read<std::uint8_t>();
  response.build = reader.read<std::uint16_t>();
  response.name.assign(as_text(reader.take(response.name.kCapacity)));
  return all_of_response(reader, response, data.size());
}

void AddNotificationResponse::encode(LittleWriter& writer) const noexcept {
  writer.write(result);
  writer.write(handle);
}

Result<AddNotificationResponse> AddNotificationResponse::decode(Bytes data) noexcept {
  LittleReader reader{data};
  AddNotificationResponse response;
  response.result = reader.read<std::uint32_t>();
  response.handle = reader.read<std::uint32_t>();
  return all_of_response(reader, response, data.size());
}

SumItem sum_item(Bytes data, std::size_t n) noexcept {
  LittleReader reader{data.subspan(n * kSumItemSize, kSumItemSize)};
  SumItem item;
  item.index_group = reader.read<std::uint32_t>();
  item.index_offset = reader.read<std::uint32_t>();
  item.length = reader.read<std::uint32_t>();
  return item;
}

void SumReadWriteItem::encode(LittleWriter& writer) const noexcept {
  writer.write(index_group);
  writer.write(index_offset);
  writer.write(read_length);
  writer.write(write_length);
}

SumReadWriteItem sum_read_write_item(Bytes data, std::size_t n) noexcept {
  LittleReader reader{data.subspan(n * kSumReadWriteItemSize, kSumReadWriteItemSize)};
  SumReadWriteItem item;
  item.index_group = reader.read<std::uint32_t>();
  item.index_offset = reader.read<std::uint32_t>();
  item.read_length = reader.read<std::uint32_t>();
  item.write_length = reader.read<std::uint32_t>();
  return item;
}

}  // namespace motionlab::winch
