// Any bytes: decoding survives, only the two sizes are taken, no number that is none or beyond all platforms
// comes through, and what is accepted is written again byte for byte.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "drivers/plc_reply/plc_reply_wire.hpp"

namespace {

void require(bool holds) {
  if (!holds) std::abort();
}

bool within(const auto& values, double limit) {
  return std::ranges::all_of(values, [limit](double value) { return std::abs(value) <= limit; });
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace motionlab;
  const Bytes bytes{data, size};
  require(plc_reply::decode_request(bytes).ok() == (size == plc_reply::kRequestSize));
  if (const auto reply = plc_reply::decode_reply(bytes)) {
    require(size == plc_reply::kReplySize);
    for (const auto& platform : reply->platforms) {
      require(within(std::array{platform.eta[0], platform.eta[1], platform.eta[2]}, 10.0));
      require(within(std::array{platform.eta[3], platform.eta[4]}, 1.5708));
      require(std::isfinite(platform.eta[5]));
    }
    for (const auto& unit : reply->mrus) require(within(unit.v, 10.0));
    require(std::ranges::equal(plc_reply::encode(*reply), bytes));
  }
  return 0;
}
