/// @file  Estimate against truth over a run of the whole line: how large the errors are for what the
/// estimator says of them.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>

#include "gateway/math/rotation.hpp"
#include "gateway/service/snapshot.hpp"
#include "tests/integration/line.hpp"

namespace motionlab::integration {

/// Errors of one quantity in units of its reported standard deviation.
class Consistency {
 public:
  void add(double error, double sd) {
    ++count_;
    error2_ += error * error;
    sd2_ += sd * sd;
    nees_ += error * error / (sd * sd);
    within_3sd_ += std::abs(error) <= 3 * sd;
  }
  /// Mean of (error / sd)²: 1 when the deviations are what the errors are.
  [[nodiscard]] double nees() const { return nees_ / n(); }
  [[nodiscard]] double error_rms() const { return std::sqrt(error2_ / n()); }
  [[nodiscard]] double sd_rms() const { return std::sqrt(sd2_ / n()); }
  [[nodiscard]] double share_within_3sd() const { return within_3sd_ / n(); }

 private:
  [[nodiscard]] double n() const { return std::max(count_, 1.0); }
  double count_ = 0, error2_ = 0, sd2_ = 0, nees_ = 0, within_3sd_ = 0;
};

/// What a run came to. Lengths in m, angles in rad, world axes.
struct ConsistencyOfRun {
  std::array<Consistency, 3> tool, load, platform, euler;
  std::array<estimator::Innovations, estimator::kReadings> innovations;

  [[nodiscard]] const estimator::Innovations& of(estimator::Reading kind) const {
    return innovations[static_cast<std::size_t>(kind)];
  }
};

/// A line with a second estimator beside the gateway's own. It hears the same samples, so that it says the
/// same and its innovations can be looked at.
class JudgedLine : public Line {
 public:
  explicit JudgedLine(const lockstep::Config& config)
      : Line(config),
        inputs_(config.gateway, lockstep().bus(), nothing_sent_),
        estimator_(config.gateway.belief) {
    const math::Matrix3d& R_WN = config.gateway.belief.calibration.X_WN.R;
    R_WD_.col(2) = -Eigen::Vector3d::UnitZ();
    R_WD_.col(0) = Eigen::Vector3d(R_WN(0, 0), R_WN(1, 0), 0).normalized();
    R_WD_.col(1) = R_WD_.col(2).cross(R_WD_.col(0));
  }

  /// Runs to `end_s` and judges every step from `from_s` on.
  ConsistencyOfRun judge(double from_s, double end_s) {
    ConsistencyOfRun sum;
    while (now_s() < end_s - 1e-9) {
      step();
      const auto& now = newest_.take(inputs_.gather(this->now()));
      estimate_ =
          estimator_.step({now.t, now.mru, now.load, now.platform, now.arm, now.winch, now.second_mru});
      if (now_s() >= from_s) compare(sum);
    }
    for (std::size_t i = 0; i < estimator::kReadings; ++i) {
      sum.innovations[i] = estimator_.innovations(static_cast<estimator::Reading>(i));
    }
    return sum;
  }

  [[nodiscard]] const topic::Estimate& estimate() const { return estimate_; }

 private:
  void compare(ConsistencyOfRun& sum) {
    const topic::TruthWorld truth = lockstep().lab().truth();
    const auto rotation = [](const std::array<double, 4>& q) {
      return math::RigidTransform::from_quaternion(Eigen::Map<const Eigen::Vector4d>(q.data()), {}).R;
    };
    const Eigen::Vector3d turn =
        math::to_euler(R_WD_.transpose() * rotation(estimate_.q_world_platform), math::EulerOrder::zyx) -
        math::to_euler(R_WD_.transpose() * rotation(truth.q_world_platform), math::EulerOrder::zyx);
    for (std::size_t k = 0; k < 3; ++k) {
      sum.tool[k].add(estimate_.p_world_tool_m[k] - truth.p_world_tool_m[k], estimate_.p_world_tool_sd_m[k]);
      sum.load[k].add(estimate_.p_world_load_m[k] - truth.p_world_load_m[k], estimate_.p_world_load_sd_m[k]);
      sum.platform[k].add(estimate_.p_world_platform_m[k] - truth.p_world_platform_m[k],
                          estimate_.p_world_platform_sd_m[k]);
      sum.euler[k].add(turn[static_cast<Eigen::Index>(k)], estimate_.euler_platform_sd_rad[k]);
    }
  }

  service::ArmSchedule nothing_sent_;
  service::Inputs inputs_;
  service::Newest newest_;
  estimator::LabEstimator estimator_;
  topic::Estimate estimate_;
  math::Matrix3d R_WD_;
};

}  // namespace motionlab::integration
