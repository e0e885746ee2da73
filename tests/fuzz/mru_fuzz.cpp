// Any bytes: decode survives, and what it accepts can be written again, the undocumented checksum byte apart.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "drivers/mru/mru_wire.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace motionlab;
  static const mru::Layout layout;
  const Bytes bytes{data, size};
  const auto frame = mru::decode(bytes, layout);
  if (!frame) return 0;
  std::array<std::uint8_t, mru::kMaxDatagram> room{};
  const auto again = mru::encode(*frame, layout, mru::ChecksumRule::sum8, room);
  if (!again || again->size() != size) std::abort();
  if (!std::equal(again->begin(), again->end() - 1, bytes.begin(), bytes.end() - 1)) std::abort();
  const bool sum8 = again->back() == bytes.back();
  if (sum8 != frame->checksum_match.sum8) std::abort();
  return 0;
}
