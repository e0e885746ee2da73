/// @file  Derivatives to the last digit of functions that are written for any scalar: the imaginary part of
/// f(x + i h) / h has no difference of nearly equal numbers in it, so h can be as small as one likes.
#pragma once

#include <Eigen/Core>
#include <complex>
#include <limits>

namespace motionlab::math {

/// df/dx of a function from a column vector to a column vector, both of fixed size. `f` is called with
/// std::complex<double> entries and must be analytic there: no abs, no comparison, no transpose by adjoint.
template <int N, class Function>
[[nodiscard]] auto complex_step_jacobian(const Function& f, const Eigen::Matrix<double, N, 1>& x) {
  using Complex = std::complex<double>;
  using Result = decltype(f(Eigen::Matrix<Complex, N, 1>()));
  constexpr double h = std::numeric_limits<double>::epsilon() * 1e-20;
  Eigen::Matrix<double, Result::RowsAtCompileTime, N> J;
  Eigen::Matrix<Complex, N, 1> moved = x.template cast<Complex>();
  for (int i = 0; i < N; ++i) {
    moved[i] = Complex(x[i], h);
    const Result y = f(moved);
    J.col(i) = y.imag() / h;
    moved[i] = x[i];
  }
  return J;
}

}  // namespace motionlab::math
