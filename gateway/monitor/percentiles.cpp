#include "gateway/monitor/percentiles.hpp"

#include <algorithm>

namespace motionlab::monitor {

Percentiles percentiles_of(std::vector<double> samples) {
  if (samples.empty()) return {};
  std::ranges::sort(samples);
  // In whole hundredths, so that no rounding moves a rank.
  const auto at = [&samples](std::size_t percent) {
    return samples[(percent * samples.size() + 99) / 100 - 1];
  };
  return {samples.size(), samples.front(), at(50), at(95), at(99), samples.back()};
}

}  // namespace motionlab::monitor
