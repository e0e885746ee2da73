// Everything that reads bytes of a Qualisys server: datagrams, the stream, frames, lists of bodies.
#include <array>
#include <cstdint>
#include <cstdlib>

#include "drivers/qualisys/qualisys_wire.hpp"
#include "drivers/qualisys/qualisys_wire_data.hpp"
#include "drivers/qualisys/qualisys_wire_xml.hpp"

namespace {

using namespace motionlab;
using namespace motionlab::qualisys;

void require(bool condition) {
  if (!condition) std::abort();
}

/// What was accepted must survive being sent on. The matrix may lose a rounding error, so poses are not
/// compared bit by bit, but whether they are there is.
void check_frame(Bytes payload) {
  const auto frame = decode_data(payload);
  if (!frame) return;
  std::array<std::uint8_t, 8192> buffer{};
  const auto packet = encode_data(
      *frame, {.bodies_with_residual = frame->has_bodies, .timecode = frame->timecode.has_value()}, buffer);
  require(packet.ok());
  const auto again = decode_data(packet->subspan(kPacketHeaderSize));
  require(again.ok());
  require(again->timestamp_us == frame->timestamp_us && again->frame_number == frame->frame_number);
  require(again->timecode == frame->timecode && again->body_count == frame->body_count);
  for (std::size_t i = 0; i < frame->body_count; ++i)
    require(again->body[i].tracked == frame->body[i].tracked);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const Bytes bytes{data, size};
  check_frame(bytes);
  if (const auto packet = decode_datagram(bytes)) check_frame(packet->payload);
  (void)parse_bodies_xml(as_text(bytes));

  // The stream, cut where the first byte says.
  PacketSplitter splitter{4096};
  const std::size_t cut = size == 0 ? 0 : data[0] % size;
  for (const Bytes part : {bytes.first(cut), bytes.subspan(cut)}) {
    splitter.push(part);
    while (const auto packet = splitter.next()) {
      if (!*packet) return 0;
      require((*packet)->payload.size() + kPacketHeaderSize <= 4096);
      (void)decode_event((*packet)->payload);
      (void)packet_text((*packet)->payload);
      check_frame((*packet)->payload);
    }
  }
  return 0;
}
