// Any bytes as an MCAP file: read to an end or to a fault behind which nothing is known, in bounded memory.
// What comes out as a snapshot of the control thread is read, too, and comes back the same from the bytes
// that its values make. What is repaired is whole.
#include <cstdint>
#include <cstdlib>
#include <sstream>
#include <string>

#include "gateway/record/cdr.hpp"
#include "gateway/record/inspection.hpp"
#include "gateway/record/mcap_reader.hpp"
#include "idl/snapshot.hpp"

namespace {

using namespace motionlab;

void read_and_write(Bytes cdr) {
  static topic::Snapshot sample;
  static ByteBuffer written(96 * 1024), again(96 * 1024);
  if (!record::read_cdr(cdr, sample)) return;
  const std::size_t size = record::write_cdr(sample, written);
  if (size == 0) std::abort();
  if (!record::read_cdr(Bytes{written}.first(size), sample)) std::abort();
  if (record::write_cdr(sample, again) != size) std::abort();
  if (!std::equal(written.begin(), written.begin() + static_cast<std::ptrdiff_t>(size), again.begin()))
    std::abort();
}

/// Of whatever there is, a whole file with as many messages can be made.
void repair(const std::string& bytes) {
  std::istringstream in(bytes);
  std::ostringstream out;
  const record::Inspection before = record::repair(in, out);
  std::istringstream made(out.str());
  const record::Inspection after = record::inspect(made);
  if (!after.whole() || after.messages() != before.messages()) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string bytes(reinterpret_cast<const char*>(data), size);
  repair(bytes);
  std::istringstream in(bytes);
  record::McapReader reader(in);
  std::size_t seen = 0;
  for (;;) {
    const auto item = reader.next();
    if (!item && reader.skip()) continue;
    if (!item || !item->has_value()) break;
    if (const auto* message = std::get_if<record::McapMessage>(&**item)) {
      seen += message->channel->topic.size() + message->data.size();
      read_and_write(message->data);
    } else if (const auto* attachment = std::get_if<record::McapAttachment>(&**item)) {
      seen += attachment->data.size();
    }
  }
  if (reader.position() > size || (reader.complete() && reader.position() < 16)) std::abort();
  return seen == SIZE_MAX ? 1 : 0;
}
