// What a Qualisys server sends, in either byte order: datagrams, the stream, frames, discovery. Its XML and
// the commands of clients have fuzzers of their own.
#include <array>
#include <cstdint>
#include <cstdlib>

#include "drivers/qualisys/qualisys_wire.hpp"
#include "drivers/qualisys/qualisys_wire_data.hpp"
#include "drivers/qualisys/qualisys_wire_discovery.hpp"

namespace {

using namespace motionlab;
using namespace motionlab::qualisys;

constexpr Components kAll{Component::bodies,     Component::bodies_res,     Component::angles,
                          Component::angles_res, Component::markers,        Component::markers_res,
                          Component::unlabelled, Component::unlabelled_res, Component::timecode};

void require(bool condition) {
  if (!condition) std::abort();
}

/// What was accepted must survive being sent on. The matrix may lose a rounding error, so poses are not
/// compared bit by bit, but whether they are there is.
void check_frame(Bytes payload, std::endian order) {
  const auto frame = decode_data(payload, order);
  if (!frame) return;
  static std::array<std::uint8_t, kDatagramLimit> buffer;
  const auto packet = encode_data(*frame, kAll, buffer, order);
  require(packet.ok());
  const auto again = decode_data(packet->subspan(kPacketHeaderSize), order);
  require(again.ok());
  require(again->timestamp_us == frame->timestamp_us && again->frame_number == frame->frame_number);
  require(again->timecode == frame->timecode);
  require(again->bodies.size == frame->bodies.size && again->angles.size == frame->angles.size);
  require(again->markers.size == frame->markers.size && again->unlabelled.size == frame->unlabelled.size);
  for (std::size_t i = 0; i < frame->bodies.size; ++i)
    require(again->bodies.all[i].tracked == frame->bodies.all[i].tracked);
  for (std::size_t i = 0; i < frame->unlabelled.size; ++i)
    require(again->unlabelled.all[i].id == frame->unlabelled.all[i].id);
}

/// The stream, cut where the first byte says.
void check_stream(Bytes bytes, std::endian order) {
  constexpr std::size_t kLimit = 4096;
  PacketSplitter splitter{kLimit, order};
  const std::size_t cut = bytes.empty() ? 0 : bytes[0] % bytes.size();
  for (const Bytes part : {bytes.first(cut), bytes.subspan(cut)}) {
    splitter.push(part);
    while (const auto packet = splitter.next()) {
      if (!*packet) return;
      require((*packet)->payload.size() + kPacketHeaderSize <= kLimit);
      (void)decode_event((*packet)->payload);
      (void)packet_text((*packet)->payload);
      check_frame((*packet)->payload, order);
    }
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const Bytes bytes{data, size};
  for (const std::endian order : {std::endian::little, std::endian::big}) {
    check_frame(bytes, order);
    if (const auto packet = decode_datagram(bytes, order)) check_frame(packet->payload, order);
    check_stream(bytes, order);
  }
  if (const auto port = decode_discovery(bytes)) require(decode_discovery(encode_discovery(*port)).ok());
  if (const auto answer = decode_discovery_answer(bytes)) {
    const ByteBuffer written = encode_discovery_answer(*answer);
    require(std::equal(written.begin(), written.end(), bytes.begin(), bytes.end()));
  }
  return 0;
}
