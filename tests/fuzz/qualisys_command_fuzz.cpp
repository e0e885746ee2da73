// What clients of a Qualisys server say.
#include <cstdint>
#include <cstdlib>

#include "drivers/core/bytes.hpp"
#include "drivers/qualisys/qualisys_wire_command.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace motionlab;
  using namespace motionlab::qualisys;
  const auto parsed = parse_command(as_text({data, size}));
  if (!parsed) return 0;
  if (const auto* stream = std::get_if<command::StreamFrames>(&*parsed)) {
    if (stream->components.empty() || stream->divisor == 0) std::abort();
    if (stream->rate_hz && !(*stream->rate_hz > 0.0)) std::abort();
    if (stream->udp && stream->udp->port < 1023) std::abort();
  }
  if (const auto* version = std::get_if<command::Version>(&*parsed))
    if (version->minor && *version->minor < -1) std::abort();
  return 0;
}
