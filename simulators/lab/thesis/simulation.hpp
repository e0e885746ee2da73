/// @file  Runs a scenario of the thesis and shows every millisecond of it to whoever asks.
#pragma once

#include <Eigen/Core>
#include <functional>

#include "simulators/lab/thesis/scenario.hpp"

namespace motionlab::thesis {

/// What a law is given to act on, and what that was made from. Without a filter everything is the truth;
/// without a ship `eta_measured` and `eta_estimate` are zero.
struct Sight {
  Eigen::Matrix<double, 10, 1> estimate;  ///< the state, as in `Sample`
  Eigen::Vector2d swing_measured_rad = Eigen::Vector2d::Zero();
  /// The ship's x, y, z [m] in N and roll, pitch, yaw [rad].
  Eigen::Matrix<double, 6, 1> eta_measured = Eigen::Matrix<double, 6, 1>::Zero();
  Eigen::Matrix<double, 6, 1> eta_estimate = Eigen::Matrix<double, 6, 1>::Zero();
};

/// One millisecond, at its beginning. In the pendulum, x stands in p.x and theta in the place of alpha.
struct Sample {
  std::int64_t t_ms = 0;
  Eigen::Matrix<double, 10, 1> state;  ///< tool point, velocity in the robot's axes, swing angles, rates
  Sight sight;                         ///< the same as the law was given it
  Eigen::Vector3d p_RT_reference;      ///< [m]
  Eigen::Vector3d command;             ///< acceleration asked for, in the robot's axes [m/s²]
  Eigen::Vector3d p_WT, p_WL;          ///< tool point and load in world [m]
  Eigen::Vector3d p_WT_set, p_WL_set;  ///< where they should be: ship at neutral, plumb
  double wire_m = 0;
  double wire_speed_mps = 0;
  Eigen::Matrix<double, 6, 1> eta = Eigen::Matrix<double, 6, 1>::Zero();  ///< the ship's coordinates in N
};

using Observer = std::function<void(const Sample&)>;

/// Tool point at home in the robot's axes [m] (Tab 4.1; with the code's forearm of 1.4922 m).
[[nodiscard]] Eigen::Vector3d home_m();

/// Simulates with classical Runge–Kutta steps of 1 ms and calls `observer` for every one of them, before it
/// is taken. With `ideal` the law acts at every stage of a step, and its memory is integrated with the plant;
/// with a filter it acts once a millisecond on the newest estimate and its command is held.
void simulate(const Run& run, const Observer& observer);

}  // namespace motionlab::thesis
