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
  static constexpr std::size_t kCapacity = 24;
  std::array<Entry, kCapacity> entries_;
  std::size_t count_ = 0;
};

/// What one scalar measurement came to.
struct SparseUpdate {
  bool taken = false;  ///< false: beyond the gate, or not finite
  double nis = 0;      ///< innovation² over its variance: 1 on average when the models hold

  explicit operator bool() const { return taken; }
};

/// State x (N) and covariance P (N x N) of a Kalman filter.
template <int N>
struct KalmanState {
  using Vector = Eigen::Matrix<double, N, 1>;
  using Matrix = Eigen::Matrix<double, N, N>;

  Vector x = Vector::Zero();
  Matrix P = Matrix::Zero();

  /// Takes in one scalar measurement with the given innovation (measured − predicted) and noise variance.
  ///
  /// The update of P is the rank-one form P − r rᵀ with r = P hᵀ / √s, exactly symmetric by construction.
  /// @param gate  innovations larger than this many standard deviations are refused
  /// @returns whether the measurement was taken in, and how far it was off for what was expected
  SparseUpdate update(const SparseRow& h, double innovation, double variance, double gate) {
    Eigen::Matrix<double, N, 1> Ph = Eigen::Matrix<double, N, 1>::Zero();
    for (const auto& [index, value] : h) Ph.noalias() += value * P.col(index);
    double s = variance;
    for (const auto& [index, value] : h) s += value * Ph[index];
    const double nis = innovation * innovation / s;
    if (!(nis <= gate * gate && s > 0)) return {false, nis};
    const double root = std::sqrt(s);
    const Eigen::Matrix<double, N, 1> r = Ph / root;
    x.noalias() += (innovation / root) * r;
    P.noalias() -= r * r.transpose();
    return {true, nis};
  }
};

}  // namespace motionlab::math
