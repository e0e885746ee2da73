// Any bytes as a TCP stream from a controller or a client: nothing may crash, and what is accepted must come
// back byte for byte where the format has one spelling only.
#include <algorithm>
#include <cstdlib>
#include <vector>

#include "drivers/winch/winch_wire.hpp"

namespace {

using namespace motionlab;
using namespace motionlab::winch;

template <class Message>
void decode_and_compare(Bytes data, bool one_spelling = true) {
  const auto message = Message::decode(data);
  if (!message) return;
  static std::vector<std::uint8_t> buffer;
  buffer.resize(data.size() + 64);
  LittleWriter writer{buffer};
  message->encode(writer);
  if (!writer.ok()) std::abort();
  if (!one_spelling) return;
  const Bytes again = writer.written();
  if (!std::equal(again.begin(), again.end(), data.begin(), data.end())) std::abort();
}

void walk(Bytes data) {
  const auto opened = NotificationReader::open(data);
  if (!opened) return;
  NotificationReader reader = *opened;
  while (reader.next()) {
  }
  if (!reader.ok()) std::abort();
}

void walk_entries(Bytes data) {
  EntryReader symbols{data};
  while (true) {
    const auto next = symbols.next();
    if (!next || !*next) break;
    decode_and_compare<SymbolEntry>(**next, false);
    const auto type = DataTypeEntry::decode(**next);
    if (!type) continue;
    EntryReader members{type->member_entries};
    for (std::uint16_t i = 0; i < type->members; ++i) {
      const auto member = members.next();
      if (!member || !*member) std::abort();
      (void)DataTypeEntry::decode(**member);
    }
  }
}

void walk_sums(Bytes data) {
  for (std::size_t i = 0; i < data.size() / kSumItemSize; ++i) (void)sum_item(data, i);
  for (std::size_t i = 0; i < data.size() / kSumReadWriteItemSize; ++i) (void)sum_read_write_item(data, i);
}

void take(Bytes data) {
  decode_and_compare<ReadRequest>(data);
  decode_and_compare<WriteRequest>(data);
  decode_and_compare<ReadWriteRequest>(data);
  decode_and_compare<WriteControlRequest>(data);
  decode_and_compare<AddNotificationRequest>(data, false);  // reserved bytes
  decode_and_compare<DeleteNotificationRequest>(data);
  decode_and_compare<ResultResponse>(data);
  decode_and_compare<ReadResponse>(data, false);  // an error may stand alone
  decode_and_compare<ReadStateResponse>(data, false);
  decode_and_compare<DeviceInfoResponse>(data, false);  // bytes behind the name's NUL
  decode_and_compare<AddNotificationResponse>(data, false);
  decode_and_compare<SymbolPlace>(data);
  decode_and_compare<SymbolEntry>(data, false);  // bytes behind the comment
  decode_and_compare<PlcCommand>(data, false);   // reserved bytes, BOOLs other than 1
  decode_and_compare<PlcStatus>(data, false);
  decode_and_compare<UploadInfo>(data, data.size() == 24);
  decode_and_compare<LegacyStatus>(data);
  decode_and_compare<LegacyCommand>(data, false);  // BOOLs other than 1
  walk(data);
  walk_entries(data);
  walk_sums(data);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  const Bytes input{bytes, size};
  take(input);
  FrameSplitter splitter;
  const std::size_t half = size / 2;
  for (const Bytes part : {input.first(half), input.subspan(half)}) {
    splitter.append(part);
    while (true) {
      const auto next = splitter.next();
      if (!next || !*next) break;
      const auto frame = decode_ams((**next).body);
      if (!frame) continue;
      (void)describe(frame->header.error);
      take(frame->data);
    }
  }
  return 0;
}
