/// @file  What a linear system ẋ = Ax + Bu, y = Cx can be made to do and lets be seen. For design, not for
/// the control cycle: these allocate.
#pragma once

#include <Eigen/Core>

namespace motionlab::math {

/// [B, AB, …, Aⁿ⁻¹B], Kalman's matrix. n x nm. For small systems: its columns soon grow nearly parallel.
[[nodiscard]] Eigen::MatrixXd controllability_matrix(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B);

/// An orthonormal basis of what the inputs can reach, the span of Kalman's matrix, built power by power: each
/// new block is made orthogonal to what is there, and its directions with singular values above `tolerance`
/// (relative to the norm of the block's factors) are added. Its number of columns is the controllability
/// rank.
[[nodiscard]] Eigen::MatrixXd reachable_space(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B,
                                              double tolerance = 1e-9);

/// Kalman's controllability rank.
[[nodiscard]] int controllability_rank(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B,
                                       double tolerance = 1e-9);

/// Kalman's observability rank. @param C  the measurements, rows
[[nodiscard]] int observability_rank(const Eigen::MatrixXd& A, const Eigen::MatrixXd& C,
                                     double tolerance = 1e-9);

/// An orthonormal basis of the states that never show in y = Cx. n x (n − rank).
[[nodiscard]] Eigen::MatrixXd unobservable_space(const Eigen::MatrixXd& A, const Eigen::MatrixXd& C,
                                                 double tolerance = 1e-9);

/// Diagonal weights behind a gain.
struct RecoveredWeights {
  Eigen::VectorXd q;  ///< the diagonal of Q, for R = 1
  double fit = 0;     ///< relative error with which the return-difference identity holds with these weights
};

/// The diagonal Q (R = 1) for which the single-input gain k is optimal: the return-difference identity
/// |1 + k (sI−A)⁻¹b|² = 1 + Σ q_i |((sI−A)⁻¹b)_i|² at several frequencies, which is linear in q. A negative q
/// says that no such regulator has this gain. @pre (A, b) controllable, k stabilises
[[nodiscard]] RecoveredWeights recover_weights(const Eigen::MatrixXd& A, const Eigen::VectorXd& b,
                                               const Eigen::RowVectorXd& k);

}  // namespace motionlab::math
