/// @file  The Kalman filter and its extended form for fixed sizes: predict, and update by Joseph's form or
/// row by row. The caller brings the models; nothing is allocated and nothing throws.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <limits>
#include <optional>

#include "gateway/math/sparse_kalman.hpp"

namespace motionlab::math {

/// Linear prediction: x ← F x + b, P ← F P Fᵀ + Q. `b` is what the known inputs add (B u).
template <int N>
void predict(KalmanState<N>& state, const Eigen::Matrix<double, N, N>& F,
             const Eigen::Matrix<double, N, 1>& b, const Eigen::Matrix<double, N, N>& Q) {
  const Eigen::Matrix<double, N, 1> x = F * state.x + b;
  const Eigen::Matrix<double, N, N> FP = F * state.P;
  state.x = x;
  state.P = Q;
  state.P.noalias() += FP * F.transpose();
  state.P = (0.5 * (state.P + state.P.transpose())).eval();
}

/// Extended prediction: x ← f(x), P ← F P Fᵀ + Q with F = df/dx at the old x, which the caller evaluates
/// there (thesis Eq 3.162–3.164).
template <int N>
void predict_extended(KalmanState<N>& state, const Eigen::Matrix<double, N, 1>& f_of_x,
                      const Eigen::Matrix<double, N, N>& F, const Eigen::Matrix<double, N, N>& Q) {
  predict<N>(state, F, f_of_x - F * state.x, Q);
  state.x = f_of_x;  // exactly, without the rounding of F x − F x
}

/// What an update did.
template <int N, int M>
struct KalmanUpdate {
  Eigen::Matrix<double, N, M> K;  ///< the gain
  Eigen::Matrix<double, M, M> S;  ///< covariance of the innovation
  double nis = 0;  ///< νᵀS⁻¹ν: chi-squared with M degrees of freedom when the models hold
};

/// Update with M measurements at once, in Joseph's form P ← (I−KH) P (I−KH)ᵀ + K R Kᵀ, which stays symmetric
/// and positive whatever rounding does to K.
///
/// @param H           derivative of the measurements with respect to the state, at the predicted x (thesis
///                    Eq 3.167, which must read dh/dx). M x N
/// @param innovation  z − h(x); for a linear filter z − H x
/// @param R           covariance of the measurement noise, symmetric, possibly with correlations
/// @returns nothing, and leaves the state alone, when S is not positive definite or the innovation not finite
template <int N, int M>
[[nodiscard]] std::optional<KalmanUpdate<N, M>> update(KalmanState<N>& state,
                                                       const Eigen::Matrix<double, M, N>& H,
                                                       const Eigen::Matrix<double, M, 1>& innovation,
                                                       const Eigen::Matrix<double, M, M>& R) {
  KalmanUpdate<N, M> done;
  const Eigen::Matrix<double, N, M> PHt = state.P * H.transpose();
  done.S = R;
  done.S.noalias() += H * PHt;
  const Eigen::LLT<Eigen::Matrix<double, M, M>> factor(done.S);
  if (factor.info() != Eigen::Success || !innovation.allFinite()) return std::nullopt;
  done.K = factor.solve(PHt.transpose()).transpose();
  done.nis = innovation.dot(factor.solve(innovation));
  Eigen::Matrix<double, N, N> I_KH = Eigen::Matrix<double, N, N>::Identity();
  I_KH.noalias() -= done.K * H;
  const Eigen::Matrix<double, N, N> half = I_KH * state.P;
  const Eigen::Matrix<double, N, M> KR = done.K * R;
  state.x.noalias() += done.K * innovation;
  state.P.noalias() = half * I_KH.transpose();
  state.P.noalias() += KR * done.K.transpose();
  state.P = (0.5 * (state.P + state.P.transpose())).eval();
  return done;
}

/// The same with uncorrelated measurement noise, one row after the other: no matrix is inverted, and rows
/// with many zeros cost little. Equal to `update` to rounding. `innovation` is z − h(x) of all rows at the
/// predicted x; what the rows before have already moved x is accounted for here.
///
/// @param variances  the diagonal of R, each positive
/// @param gate       rows beyond this many standard deviations are left out
/// @returns how many rows were taken in
template <int N, int M>
int update_row_by_row(KalmanState<N>& state, const Eigen::Matrix<double, M, N>& H,
                      const Eigen::Matrix<double, M, 1>& innovation,
                      const Eigen::Matrix<double, M, 1>& variances,
                      double gate = std::numeric_limits<double>::infinity()) {
  const Eigen::Matrix<double, N, 1> predicted = state.x;
  int taken = 0;
  for (int row = 0; row < M; ++row) {
    const double left = innovation[row] - H.row(row).dot(state.x - predicted);
    Eigen::Matrix<double, N, 1> Ph = Eigen::Matrix<double, N, 1>::Zero();
    for (int i = 0; i < N; ++i) {
      if (H(row, i) != 0) Ph.noalias() += H(row, i) * state.P.col(i);
    }
    const double s = H.row(row).dot(Ph) + variances[row];
    if (!(s > 0) || !(std::abs(left) <= gate * std::sqrt(s))) continue;
    const double root = std::sqrt(s);
    const Eigen::Matrix<double, N, 1> r = Ph / root;
    state.x.noalias() += (left / root) * r;
    state.P.noalias() -= r * r.transpose();
    ++taken;
  }
  return taken;
}

}  // namespace motionlab::math
