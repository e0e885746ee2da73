/// @file  The continuous algebraic Riccati equation and the linear quadratic regulator, for dense systems of
/// up to about 40 states. For design, not for the control cycle: these allocate and throw.
#pragma once

#include <Eigen/Core>

namespace motionlab::math {

/// Solves AᵀX + XA − X B R⁻¹ Bᵀ X + Q = 0 for the stabilising X: the stable invariant subspace of the
/// Hamiltonian by an ordered Schur form (Laub 1979; holds for repeated eigenvalues too), polished by Newton's
/// method (Kleinman 1968). @pre Q symmetric positive semidefinite, R symmetric positive definite.
/// @throws std::runtime_error when (A, B) is not stabilisable, when a mode on the imaginary axis is not seen
/// by Q, or when the relative residual stays above 1e-8.
[[nodiscard]] Eigen::MatrixXd solve_care(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B,
                                         const Eigen::MatrixXd& Q, const Eigen::MatrixXd& R);

/// How well X solves the equation: the norm of its left side over the sum of the norms of its terms.
[[nodiscard]] double care_residual(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B,
                                   const Eigen::MatrixXd& Q, const Eigen::MatrixXd& R,
                                   const Eigen::MatrixXd& X);

/// The gain K of u = −K x that minimises ∫ xᵀQx + uᵀRu. Same conditions.
[[nodiscard]] Eigen::MatrixXd lqr(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B,
                                  const Eigen::MatrixXd& Q, const Eigen::MatrixXd& R);

/// The stationary covariance X of ẋ = Ax + w with noise density Q: AX + XAᵀ + Q = 0, by Bartels and Stewart's
/// method. @pre A stable, Q symmetric
[[nodiscard]] Eigen::MatrixXd solve_lyapunov(const Eigen::MatrixXd& A, const Eigen::MatrixXd& Q);

}  // namespace motionlab::math
