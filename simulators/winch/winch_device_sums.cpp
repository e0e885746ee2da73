#include <algorithm>

#include "simulators/winch/winch_device.hpp"

namespace motionlab::winch {

namespace {

std::uint32_t error_of(const SumItem& item, std::uint32_t error, Bytes bytes) noexcept {
  return error == ads_error::none && item.length > bytes.size() ? ads_error::invalid_size : error;
}

void write_zeros(LittleWriter& writer, std::size_t n) noexcept {
  for (std::size_t i = 0; i < n; ++i) writer.write(std::uint8_t{0});
}

}  // namespace

bool WinchDevice::is_sum(std::uint32_t group) const noexcept {
  return group >= index_group::sum_read && group <= index_group::sum_delete_notification;
}

std::uint32_t WinchDevice::sum(const AmsHeader& header, const ReadWriteRequest& request,
                               LittleWriter& answer) {
  if (request.index_offset > kSumItemsMax) return ads_error::invalid_size;
  switch (request.index_group) {
    case index_group::sum_write:
      return sum_write(header.target, request, answer);
    case index_group::sum_read_write:
      return sum_read_write(header, request, answer);
    case index_group::sum_add_notification:
      return sum_subscribe(header, request, answer);
    case index_group::sum_delete_notification:
      return sum_unsubscribe(header, request, answer);
    default:
      return sum_read(header.target, request, answer);
  }
}

/// Results first, then data. The plain form and the first extended one keep the place of an item that failed;
/// the extended ones give its length with each result.
std::uint32_t WinchDevice::sum_read(const AmsAddress& server, const ReadWriteRequest& request,
                                    LittleWriter& answer) {
  const std::size_t n = request.index_offset;
  if (request.data.size() != n * kSumItemSize) return ads_error::invalid_size;
  const bool extended = request.index_group != index_group::sum_read;
  const bool keeps_place = request.index_group != index_group::sum_read_ex_2;
  std::size_t total = n * sizeof(std::uint32_t) * (extended ? 2 : 1);
  for (std::size_t i = 0; i < n; ++i) total += sum_item(request.data, i).length;
  if (total > request.read_length || total > data_.size()) return ads_error::invalid_size;
  for (std::size_t i = 0; i < n; ++i) {
    const SumItem item = sum_item(request.data, i);
    const Place found = place(server, item.index_group, item.index_offset);
    const auto error = error_of(item, found.error, found.bytes);
    answer.write(error);
    if (extended) answer.write(error == ads_error::none ? item.length : 0U);
  }
  for (std::size_t i = 0; i < n; ++i) {
    const SumItem item = sum_item(request.data, i);
    const Place found = place(server, item.index_group, item.index_offset);
    if (error_of(item, found.error, found.bytes) == ads_error::none) {
      answer.write_bytes(found.bytes.first(item.length));
    } else if (keeps_place) {
      write_zeros(answer, item.length);
    }
  }
  return ads_error::none;
}

std::uint32_t WinchDevice::sum_write(const AmsAddress& server, const ReadWriteRequest& request,
                                     LittleWriter& answer) {
  const std::size_t n = request.index_offset;
  if (request.data.size() < n * kSumItemSize) return ads_error::invalid_size;
  LittleReader values{request.data.subspan(n * kSumItemSize)};
  std::size_t total = 0;
  for (std::size_t i = 0; i < n; ++i) total += sum_item(request.data, i).length;
  if (total != values.remaining()) return ads_error::invalid_size;
  for (std::size_t i = 0; i < n; ++i) {
    const SumItem item = sum_item(request.data, i);
    answer.write(write_value(server, item.index_group, item.index_offset, values.take(item.length)));
  }
  return ads_error::none;
}

/// Results with lengths first, then the data packed. A sum inside a sum is refused.
std::uint32_t WinchDevice::sum_read_write(const AmsHeader& header, const ReadWriteRequest& request,
                                          LittleWriter& answer) {
  const std::size_t n = request.index_offset;
  if (request.data.size() < n * kSumReadWriteItemSize) return ads_error::invalid_size;
  LittleReader values{request.data.subspan(n * kSumReadWriteItemSize)};
  std::size_t to_write = 0;
  for (std::size_t i = 0; i < n; ++i) to_write += sum_read_write_item(request.data, i).write_length;
  if (to_write != values.remaining()) return ads_error::invalid_size;
  LittleWriter packed{item_};
  for (std::size_t i = 0; i < n; ++i) {
    const SumReadWriteItem item = sum_read_write_item(request.data, i);
    const ReadWriteRequest one{item.index_group, item.index_offset, item.read_length,
                               values.take(item.write_length)};
    const std::size_t before = packed.position();
    std::uint32_t error =
        is_sum(one.index_group) ? ads_error::invalid_index_group : read_write(header, one, packed);
    if (!packed.ok()) return ads_error::invalid_size;
    const std::size_t length = packed.position() - before;
    if (error == ads_error::none && length > item.read_length) return ads_error::invalid_size;
    answer.write(error);
    answer.write(static_cast<std::uint32_t>(error == ads_error::none ? length : 0));
  }
  answer.write_bytes(packed.written());
  return ads_error::none;
}

std::uint32_t WinchDevice::sum_subscribe(const AmsHeader& header, const ReadWriteRequest& request,
                                         LittleWriter& answer) {
  const std::size_t n = request.index_offset;
  if (request.data.size() != n * kSumSubscribeItemSize) return ads_error::invalid_size;
  for (std::size_t i = 0; i < n; ++i) {
    const auto item = AddNotificationRequest::decode(
        request.data.subspan(i * kSumSubscribeItemSize, kSumSubscribeItemSize));
    subscribe(header, *item).encode(answer);
  }
  return ads_error::none;
}

std::uint32_t WinchDevice::sum_unsubscribe(const AmsHeader& header, const ReadWriteRequest& request,
                                           LittleWriter& answer) {
  LittleReader handles{request.data};
  const std::size_t n = request.index_offset;
  if (request.data.size() != n * sizeof(std::uint32_t)) return ads_error::invalid_size;
  for (std::size_t i = 0; i < n; ++i) {
    answer.write(unsubscribe(header.source, handles.read<std::uint32_t>()));
  }
  return ads_error::none;
}

}  // namespace motionlab::winch
