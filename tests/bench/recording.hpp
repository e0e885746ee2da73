/// @file  What the control room hears of a laboratory, made before anything is measured.
#pragma once

#include <cstddef>
#include <vector>

#include "gateway/estimator/lab_estimator.hpp"

namespace motionlab::test {

struct Recording {
  estimator::Belief belief;
  std::vector<estimator::Inputs> heard;  ///< one a millisecond
};

/// The first periods of the estimator's test laboratory: a rolling ship, the tool held still, real noise.
[[nodiscard]] Recording record(std::size_t periods);

}  // namespace motionlab::test
