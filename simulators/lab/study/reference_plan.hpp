/// @file  Where the load is asked to be in the course of a run.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string_view>

#include "drivers/core/time.hpp"
#include "idl/reference.hpp"

namespace motionlab::study {

/// References by name, as a user's program would send them. At first, by default until 30 s, the load is
/// asked to be where the configuration says, in world; then
///  - hold: still there;
///  - step: 0.15 m on in x at once, in y 20 s later, 0.2 m down 40 s, all back 60 s later; each told once;
///  - sine: 0.10, 0.08 and 0.10 m at 0.05, 0.07 and 0.04 Hz, told with its velocity every 10 ms;
///  - follow: a circle of 0.12 m in 30 s, told with its velocity every 100 ms.
/// From then on the second ship carries the place, if it is asked to.
class ReferencePlan {
 public:
  static constexpr std::string_view kNames[] = {"hold", "step", "sine", "follow"};

  /// @param name  one of `kNames`
  ReferencePlan(std::string_view name, topic::ReferenceFrame frame, const Eigen::Vector3d& p_WL,
                double begins_s);

  struct Place {
    Eigen::Vector3d p_WL;  ///< with the second ship at neutral, if it carries the place
    Eigen::Vector3d v_WL;
    topic::ReferenceFrame frame;
  };
  [[nodiscard]] Place at(LabTime t) const;

  /// What is to be sent at this time; nothing when nothing is new. Ask in order of time.
  [[nodiscard]] std::optional<topic::Reference> next(LabTime t);

 private:
  enum class Kind { hold, step, sine, follow } kind_;
  topic::ReferenceFrame frame_;
  Eigen::Vector3d p_WL_;
  double begins_s_;
  LabTime due_{};
  Place told_;  ///< at first what the configuration says
  std::uint64_t sent_ = 0;
};

}  // namespace motionlab::study
