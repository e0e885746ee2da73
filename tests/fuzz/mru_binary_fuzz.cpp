// Any bytes as KM Binary, EM3000, EM1000 and BIN23: each decoder survives; what one accepts is written again
// byte for byte (of BIN23 when its CRC was right), and what becomes a motion is plausible.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "drivers/mru/mru_wire_bin23.hpp"
#include "drivers/mru/mru_wire_detect.hpp"
#include "drivers/mru/mru_wire_em3000.hpp"
#include "drivers/mru/mru_wire_formats.hpp"
#include "drivers/mru/mru_wire_km.hpp"

namespace {

using namespace motionlab;

void expect(bool condition) {
  if (!condition) std::abort();
}

template <class Frame>
void expect_same_again(const Frame& frame, Bytes bytes) {
  std::array<std::uint8_t, mru::kMaxDatagram> room{};
  const auto again = encode(frame, room);
  expect(again && std::ranges::equal(*again, bytes));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const Bytes bytes{data, size};
  if (const auto frame = mru::km::decode(bytes)) expect_same_again(*frame, bytes);
  if (const auto frame = mru::em3000::decode(bytes)) expect_same_again(*frame, bytes);
  if (const auto frame = mru::bin23::decode(bytes); frame && frame->crc_good)
    expect_same_again(*frame, bytes);
  for (const auto format :
       {mru::Format::km_binary, mru::Format::em3000, mru::Format::em1000, mru::Format::bin23}) {
    mru::Decoder decoder{format, {}};
    const auto heard = decoder.decode(bytes);
    if (!heard) continue;
    expect(heard->has_value() && mru::check_plausible((*heard)->motion, {}).ok());
    std::array<std::uint8_t, mru::kMaxDatagram> room{};
    for (const auto other : mru::kFormats) {
      (void)mru::encode((*heard)->motion, other, {}, mru::ChecksumRule::sum8, Nanoseconds{1}, room);
    }
  }
  mru::FormatDetector detector;
  detector.take(bytes);
  return 0;
}
