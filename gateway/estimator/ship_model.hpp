/// @file  How the states of a ship and the errors of its unit go on while nothing is measured.
#pragma once

#include <Eigen/Core>
#include <array>

#include "gateway/estimator/belief.hpp"
#include "gateway/estimator/ship_axis.hpp"
#include "gateway/estimator/ship_states.hpp"

namespace motionlab::estimator {

/// The belief of the first `ShipStates::kSize` states of a filter: six axes that move alike but not as much,
/// constant biases, a tilt error that wanders within bounds and a yaw error that walks.
class ShipModel {
 public:
  using Covariance = Eigen::Matrix<double, ShipStates::kSize, ShipStates::kSize>;

  ShipModel(const ShipBelief& ship, const MruBelief& mru);

  /// Before anything was heard.
  [[nodiscard]] Covariance prior() const;

  /// What a step in time does.
  class Step {
   public:
    /// x ← F x. x begins with the states of the ship.
    template <class Vector>
    void carry(Vector& x) const {
      for (int i = 0; i < ShipStates::kAxes; ++i) {
        auto axis = x.template segment<kAxis>(ShipStates::axis(i));
        axis = (A_ * axis).eval();
      }
      x.template segment<2>(ShipStates::kTiltError) *= tilt_decay_;
    }

    /// P ← F P Fᵀ, symmetric. P begins with the states of the ship; F leaves the others alone.
    template <class Matrix>
    void carry_covariance(Matrix& P) const {
      constexpr int kAfter = ShipStates::kAccelerationBias, kOthers = Matrix::RowsAtCompileTime - kAfter;
      for (int j = 0; j < ShipStates::kAxes; ++j) {
        const int b = ShipStates::axis(j);
        for (int i = j; i < ShipStates::kAxes; ++i) {
          const int a = ShipStates::axis(i);
          const Eigen::Matrix4d FP = A_ * P.template block<kAxis, kAxis>(a, b);
          const Eigen::Matrix4d FPF = FP * A_.transpose();
          P.template block<kAxis, kAxis>(a, b) = FPF;
          P.template block<kAxis, kAxis>(b, a) = FPF.transpose();
        }
        P.template block<kOthers, kAxis>(kAfter, b) =
            (P.template block<kOthers, kAxis>(kAfter, b) * A_.transpose()).eval();
        P.template block<kAxis, kOthers>(b, kAfter) = P.template block<kOthers, kAxis>(kAfter, b).transpose();
      }
      P.template middleCols<2>(ShipStates::kTiltError) *= tilt_decay_;
      P.template middleRows<2>(ShipStates::kTiltError) *= tilt_decay_;
    }

    /// P ← P + Q. P begins with the states of the ship.
    template <class Matrix>
    void add_noise(Matrix& P) const {
      for (int i = 0; i < ShipStates::kAxes; ++i) {
        P.template block<kAxis, kAxis>(ShipStates::axis(i), ShipStates::axis(i)) +=
            density_[static_cast<std::size_t>(i)] * Q_;
      }
      P.diagonal().template segment<2>(ShipStates::kTiltError).array() += tilt_variance_;
      P(ShipStates::kYawError, ShipStates::kYawError) += yaw_variance_;
    }

   private:
    friend class ShipModel;
    Step() = default;
    static constexpr int kAxis = ShipAxis::kSize;

    Eigen::Matrix4d A_, Q_;
    std::array<double, ShipStates::kAxes> density_;
    double tilt_decay_, tilt_variance_, yaw_variance_;
  };
  /// dt up to about 0.1 s, and for the noise up to 0.01 s.
  [[nodiscard]] Step over(double dt_s) const;

 private:
  ShipAxis axis_;
  std::array<double, ShipStates::kAxes> density_{};  ///< of the noise on each axis
  MruBelief mru_;
};

}  // namespace motionlab::estimator
