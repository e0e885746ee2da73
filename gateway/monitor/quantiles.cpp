#include "gateway/monitor/quantiles.hpp"

#include <algorithm>
#include <cmath>

namespace motionlab::monitor {
namespace {

constexpr double kGreatestStep = 1e15;  // still exact as a double

}  // namespace

Quantiles::Quantiles(double steps_per_unit, double range)
    : steps_per_unit_(steps_per_unit), counts_(static_cast<std::size_t>(range * steps_per_unit) + 1) {}

void Quantiles::add(double sample) {
  const double step = std::round(sample * steps_per_unit_);
  if (!(step >= 0) || step > kGreatestStep) return;
  const auto number = static_cast<std::uint64_t>(step);
  ++counts_[std::min<std::uint64_t>(number, counts_.size() - 1)];
  ++count_;
  max_step_ = std::max(max_step_, number);
}

double Quantiles::at(double share) const {
  const auto wanted = static_cast<std::uint64_t>(std::ceil(share * static_cast<double>(count_)));
  std::uint64_t seen = 0;
  for (std::size_t step = 0; step + 1 < counts_.size(); ++step) {
    seen += counts_[step];
    if (seen >= wanted) return static_cast<double>(step) / steps_per_unit_;
  }
  return max();
}

}  // namespace motionlab::monitor
