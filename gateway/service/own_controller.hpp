/// @file  `OwnController`: the estimator and the law of the house, and where they keep the load.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>

#include "drivers/core/time.hpp"
#include "gateway/controller/keeper.hpp"
#include "gateway/estimator/lab_estimator.hpp"
#include "gateway/service/gateway_config.hpp"
#include "gateway/service/snapshot.hpp"

namespace motionlab::service {

/// snapshot → estimate → wish. It decides nothing: whether a wish counts is a matter of modes and guard.
///
/// In a step: `take`, `estimate`, `wish`. One thread; nothing allocates after construction.
class OwnController {
 public:
  explicit OwnController(const GatewayConfig& config);

  /// Where the load shall be, as it was asked for since the last step, and what left for the arm.
  void take(const topic::Snapshot& inputs);
  [[nodiscard]] topic::Estimate estimate(const Snapshot& now);
  /// What arm and winch shall do; nothing when it knows no way.
  /// @param load_seen  when the cameras last saw the load: the longer ago, the less of the horizontal motion
  /// is compensated
  /// @param engaged  its wish counts; else it wishes rest
  [[nodiscard]] std::optional<controller::Wish> wish(const Snapshot& now, const topic::Estimate& estimate,
                                                     std::optional<LabTime> load_seen, bool engaged);

  /// The place of the load moves with the second ship.
  [[nodiscard]] bool on_second_ship() const { return reference_.on_second_ship; }
  [[nodiscard]] const Eigen::Vector3d& servo_omega_radps() const { return keeper_->servo_omega_radps(); }

 private:
  /// Where the load shall be now. A moving place goes on for a moment, then stands.
  [[nodiscard]] controller::LoadReference reference_at(LabTime t) const;
  void coast(LabTime t, std::optional<LabTime> load_seen, bool engaged);

  double control_period_s_, coast_s_, rest_by_s_;
  estimator::LabEstimator estimator_;
  std::unique_ptr<controller::Keeper> keeper_;
  controller::LoadReference reference_;
  std::optional<LabTime> reference_moved_;  ///< when a moving reference was last told
  double horizontal_share_ = 1.0;
};

}  // namespace motionlab::service
