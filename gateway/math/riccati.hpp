/// @file  The continuous algebraic Riccati equation and the linear quadratic regulator.
#pragma once

#include <Eigen/Core>

namespace motionlab::math {

/// Solves AᵀX + XA − X B R⁻¹ Bᵀ X + Q = 0 for the stabilising X, by the stable invariant subspace of the
/// Hamiltonian. @pre Q symmetric positive semidefinite, R symmetric positive definite, (A, B) stabilisable
/// and (A, Q) detectable. @throws std::runtime_error when no stabilising solution is found (relative residual
/// above 1e-8).
[[nodiscard]] Eigen::MatrixXd solve_care(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B,
                                         const Eigen::MatrixXd& Q, const Eigen::MatrixXd& R);

/// The gain K of u = −K x that minimises ∫ xᵀQx + uᵀRu. Same conditions.
[[nodiscard]] Eigen::MatrixXd lqr(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B,
                                  const Eigen::MatrixXd& Q, const Eigen::MatrixXd& R);

/// The stationary covariance X of ẋ = Ax + w with noise density Q: AX + XAᵀ + Q = 0. @pre A stable
[[nodiscard]] Eigen::MatrixXd solve_lyapunov(const Eigen::MatrixXd& A, const Eigen::MatrixXd& Q);

}  // namespace motionlab::math
