// Any bytes: decoding survives, and what is accepted is written again byte for byte.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "drivers/comau/comau_wire.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace motionlab;
  const Bytes bytes{data, size};
  if (const auto command = comau::decode_command(bytes); command.ok() && comau::check(*command).ok()) {
    if (!std::ranges::equal(comau::encode(*command), bytes)) std::abort();
  }
  if (const auto answer = comau::decode_answer(bytes)) {
    if (!std::ranges::equal(comau::encode(*answer), bytes)) std::abort();
  }
  return 0;
}
