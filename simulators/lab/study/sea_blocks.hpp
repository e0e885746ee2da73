/// @file  The four situations in which every table looks at the line.
#pragma once

#include <array>
#include <string>
#include <string_view>

#include "simulators/lab/study/lab_run.hpp"

namespace motionlab::study {

/// One scenario, with or without a camera body on the platform.
struct SeaBlock {
  std::string_view scenario;
  std::string_view platform;

  [[nodiscard]] std::string title() const {
    return std::string(scenario) + ", platform body " + std::string(platform);
  }
  /// `base` in this situation.
  [[nodiscard]] LabRun over(LabRun base) const {
    base.scenario = scenario;
    base.platform = platform;
    return base;
  }
};

[[nodiscard]] constexpr std::array<SeaBlock, 4> sea_blocks() {
  return {
      {{"thesis-wave", "tracked"}, {"thesis-wave", "untracked"}, {"sea", "tracked"}, {"sea", "untracked"}}};
}

}  // namespace motionlab::study
