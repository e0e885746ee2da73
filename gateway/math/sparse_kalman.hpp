/// @file  A Kalman filter of fixed size whose measurements are scalars that see few states. Nothing is
/// allocated.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace motionlab::math {

/// One row of a measurement matrix: the derivative of a scalar measurement with respect to a few states.
class SparseRow {
 public:
  struct Entry {
    int index;
    double value;
  };

  void add(int index, double value) {
    assert(count_ < kCapacity);
    entries_[count_++] = {index, value};
  }
  [[nodiscard]] const Entry* begin() const { return entries_.data(); }
  [[nodiscard]] const Entry* end() const { return entries_.data() + count_; }

 private:
  static constexpr std::size_t kCapacity = 12;
  std::array<Entry, kCapacity> entries_;
  std::size_t count_ = 0;
};

/// What one scalar measurement came to.
struct SparseUpdate {
  bool taken = false;  ///< false: beyond the gate, or not finite
  double nis = 0;      ///< innovation² over its variance: 1 on average when the models hold

  explicit operator bool() const { return taken; }
};

template <int N, int kAtMost>
class SparseUpdates;

/// State x (N) and covariance P (N x N, symmetric) of a Kalman filter.
template <int N>
struct KalmanState {
  using Vector = Eigen::Matrix<double, N, 1>;
  using Matrix = Eigen::Matrix<double, N, N>;

  Vector x = Vector::Zero();
  Matrix P = Matrix::Zero();

  /// One scalar measurement: `SparseUpdates` of one.
  SparseUpdate update(const SparseRow& h, double innovation, double variance, double gate) {
    return SparseUpdates<N, 1>(*this).update(h, innovation, variance, gate);
  }
};

/// Scalar measurements of one moment, linearised at the state of before, taken in one after the other.
///
/// x follows at once, P when the last is in and this object goes: P − Σ r rᵀ, one r = P hᵀ / √s of each
/// measurement, so that the large matrix is gone through once and not once for each. Until then P is that of
/// before, and nobody else may change the state.
template <int N, int kAtMost>
class SparseUpdates {
 public:
  explicit SparseUpdates(KalmanState<N>& state) : state_(state) {}
  SparseUpdates(const SparseUpdates&) = delete;
  SparseUpdates& operator=(const SparseUpdates&) = delete;
  ~SparseUpdates() {
    // Tile by tile of the lower triangle, so that each number of P is loaded and stored once. The upper
    // becomes what the lower is, whatever rounding did before.
    for (int j = 0; j < kTiled; j += kTile) {
      for (int i = j; i < kTiled; i += kTile) {
        Eigen::Matrix<double, kTile, kTile> tile = state_.P.template block<kTile, kTile>(i, j);
        for (int k = 0; k < taken_; ++k) {
          const Eigen::Matrix<double, kTile, 1> rows = told_.col(k).template segment<kTile>(i);
          for (int c = 0; c < kTile; ++c) tile.col(c) -= told_(j + c, k) * rows;
        }
        state_.P.template block<kTile, kTile>(j, i) = tile.transpose();
        if (i == j) tile.template triangularView<Eigen::StrictlyUpper>() = tile.transpose();
        state_.P.template block<kTile, kTile>(i, j) = tile;
      }
    }
    for (int i = kTiled; i < N; ++i) {
      for (int j = 0; j <= i; ++j) {
        for (int k = 0; k < taken_; ++k) state_.P(i, j) -= told_(i, k) * told_(j, k);
        state_.P(j, i) = state_.P(i, j);
      }
    }
  }

  /// Takes in one measurement, knowing what those before it have told.
  ///
  /// @param innovation  measured − predicted by the state of before the first
  /// @param gate        innovations larger than this many standard deviations are refused
  /// @returns whether the measurement was taken in, and how far it was off for what was expected
  /// @pre  fewer than kAtMost were taken in
  SparseUpdate update(const SparseRow& h, double innovation, double variance, double gate) {
    assert(taken_ < kAtMost);
    Vector Ph = Vector::Zero();
    for (const auto& [index, value] : h) Ph.noalias() += value * state_.P.col(index);
    for (int k = 0; k < taken_; ++k) {
      double along = 0;
      for (const auto& [index, value] : h) along += value * told_(index, k);
      Ph.noalias() -= along * told_.col(k);
      innovation -= along * moved_[k];
    }
    double s = variance;
    for (const auto& [index, value] : h) s += value * Ph[index];
    const double nis = innovation * innovation / s;
    if (!(nis <= gate * gate && s > 0)) return {false, nis};
    const double root = std::sqrt(s);
    told_.col(taken_) = Ph / root;
    moved_[taken_] = innovation / root;
    state_.x.noalias() += moved_[taken_] * told_.col(taken_);
    ++taken_;
    return {true, nis};
  }

 private:
  using Vector = typename KalmanState<N>::Vector;
  static constexpr int kTile = 4, kTiled = N / kTile * kTile;

  KalmanState<N>& state_;
  Eigen::Matrix<double, N, kAtMost> told_;   ///< the r of each
  Eigen::Matrix<double, kAtMost, 1> moved_;  ///< by how many of its r each moved x
  int taken_ = 0;
};

}  // namespace motionlab::math
