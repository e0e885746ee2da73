/// @file  What keeps the gateway from moving, and what must end a motion: facts for the mode machine.
#pragma once

#include <optional>

#include "drivers/core/time.hpp"
#include "gateway/controller/mode_machine.hpp"
#include "gateway/estimator/cross_check.hpp"
#include "gateway/service/gateway_config.hpp"
#include "gateway/service/snapshot.hpp"
#include "idl/estimate.hpp"

namespace motionlab::service {

/// Judges each snapshot. The first obstacle that holds is told: a code that deploy/docs/recover.md explains
/// and a sentence that says what to do. One thread; allocates nothing after construction.
class Readiness {
 public:
  explicit Readiness(const GatewayConfig& config);

  struct Inputs {
    const Snapshot& now;
    const topic::Estimate& estimate;
    double dt_s = 0;                  ///< since the last step
    bool on_second_ship = false;      ///< the reference moves with the second ship
    bool wish_missing = false;        ///< engaged, and the gateway's controller knows no way
    bool external_applicant = false;  ///< somebody asks to be engaged who commands himself
  };
  /// `t`, `links_up`, `unsafe` and `not_ready` of the facts.
  [[nodiscard]] controller::ModeFacts judge(const Inputs& inputs);

  /// Since when the load is not seen; nothing before it was.
  [[nodiscard]] std::optional<LabTime> load_seen() const { return load_seen_; }

 private:
  [[nodiscard]] std::optional<controller::Obstacle> stale(const std::vector<std::string>& devices,
                                                          const Snapshot& now) const;
  [[nodiscard]] std::optional<controller::Obstacle> unsafe(const Inputs& inputs) const;
  [[nodiscard]] std::optional<controller::Obstacle> not_ready(const Inputs& inputs) const;
  [[nodiscard]] std::optional<controller::Obstacle> disagreement() const;
  [[nodiscard]] std::optional<controller::Obstacle> applicant(const Snapshot& now) const;

  GatewayConfig config_;
  estimator::CrossCheck check_;
  std::optional<LabTime> load_seen_;
  std::optional<LabTime> mru_stable_;  ///< when the unit last called itself settled
};

}  // namespace motionlab::service
