/// @file  What every controller of the crane is given and gives, whatever its law.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "drivers/core/time.hpp"
#include "gateway/controller/wish.hpp"
#include "idl/arm_command.hpp"
#include "idl/arm_state.hpp"
#include "idl/estimate.hpp"

namespace motionlab::controller {

/// Where the load shall be. It may jump; a controller approaches it smoothly.
struct LoadReference {
  Eigen::Vector3d p_WL =
      Eigen::Vector3d::Zero();  ///< with the second ship at neutral, if it carries the place
  Eigen::Vector3d v_WL = Eigen::Vector3d::Zero();  ///< how the place itself moves
  bool on_second_ship = false;                     ///< the place moves with the second ship
};

struct KeeperInputs {
  LabTime t{};               ///< now
  LabTime t_send{};          ///< when the next command leaves
  topic::Estimate estimate;  ///< valid, for time t
  topic::ArmState arm;       ///< the newest
  LoadReference reference;
  double horizontal_share = 1.0;  ///< how much of the horizontal motion is compensated, 0…1
  bool engaged = false;
};

/// A controller of arm and winch. One thread; nothing allocates after construction.
class Keeper {
 public:
  virtual ~Keeper() = default;
  /// What left for the robot and when. Called for every command sent, engaged or not.
  virtual void sent(LabTime t, const topic::ArmCommand& command) = 0;
  /// One step. While not engaged it wishes rest, so that engaging begins without a step. No wish: it does not
  /// know what to do, and the guard stops the arm.
  [[nodiscard]] virtual std::optional<Wish> step(const KeeperInputs& inputs) = 0;
  /// ω of the crane joints' servos as taken for now [rad/s].
  [[nodiscard]] virtual const Eigen::Vector3d& servo_omega_radps() const = 0;

 protected:
  Keeper() = default;
  Keeper(const Keeper&) = default;
  Keeper& operator=(const Keeper&) = default;
};

}  // namespace motionlab::controller
