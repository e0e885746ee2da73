// Any bytes: decoding survives, only the three sizes are taken, no number that is none comes through, and
// what is accepted is written again byte for byte.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "drivers/comau/comau_wire.hpp"

namespace {

void require(bool holds) {
  if (!holds) std::abort();
}

bool all_finite(const auto& values) {
  return std::ranges::all_of(values, [](auto value) { return std::isfinite(value); });
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace motionlab;
  const Bytes bytes{data, size};
  if (const auto command = comau::decode_command(bytes)) {
    require(size == comau::kCommandSize);
    if (comau::check(*command).ok()) {
      require(all_finite(command->qd_radps));
      require(std::ranges::equal(comau::encode(*command), bytes));
    }
  }
  if (const auto answer = comau::decode_answer(bytes)) {
    require(answer->limits ? size == comau::kLongAnswerSize : size == comau::kAnswerSize);
    require(all_finite(answer->q_rad) && all_finite(answer->qd_radps));
    if (answer->limits) {
      require(all_finite(answer->limits->q_min_rad) && all_finite(answer->limits->q_max_rad) &&
              all_finite(answer->limits->qd_max_radps));
    }
    require(std::ranges::equal(comau::encode(*answer), bytes));
  }
  return 0;
}
