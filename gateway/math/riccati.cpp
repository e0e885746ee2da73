#include "gateway/math/riccati.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <complex>
#include <stdexcept>

namespace motionlab::math {

using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXcd;

namespace {

/// Orthonormal basis of the invariant subspace that belongs to the eigenvalues left of the imaginary axis.
/// @throws std::runtime_error unless these are exactly `count`, clear of the axis
MatrixXcd stable_subspace(const MatrixXd& H, Index count) {
  const Eigen::ComplexSchur<MatrixXd> schur(H);
  MatrixXcd T = schur.matrixT(), U = schur.matrixU();
  const double clear = 1e-13 * T.norm();
  Index sorted = 0;
  for (Index i = 0; i < T.rows(); ++i) {
    if (T(i, i).real() >= -clear) continue;
    // Bring it up by exchanging neighbours: a rotation onto the eigenvector of their 2x2 block.
    for (Index k = i; k > sorted; --k) {
      Eigen::JacobiRotation<std::complex<double>> J;
      J.makeGivens(T(k - 1, k), T(k, k) - T(k - 1, k - 1));
      T.applyOnTheLeft(k - 1, k, J.adjoint());
      T.applyOnTheRight(k - 1, k, J);
      U.applyOnTheRight(k - 1, k, J);
    }
    ++sorted;
  }
  if (sorted != count)
    throw std::runtime_error("no stabilising Riccati solution: check stabilisability and detectability");
  return U.leftCols(count);
}

MatrixXd symmetric(const MatrixXd& M) {
  return 0.5 * (M + M.transpose());
}

double residual(const MatrixXd& A, const MatrixXd& G, const MatrixXd& Q, const MatrixXd& X) {
  const MatrixXd XA = X * A, XGX = X * G * X;
  return (XA + XA.transpose() - XGX + Q).norm() / (2 * XA.norm() + XGX.norm() + Q.norm());
}

}  // namespace

MatrixXd solve_care(const MatrixXd& A, const MatrixXd& B, const MatrixXd& Q, const MatrixXd& R) {
  const Index n = A.rows();
  const MatrixXd G = B * R.llt().solve(B.transpose());
  MatrixXd H(2 * n, 2 * n);
  H << A, -G, -Q, -A.transpose();
  const MatrixXcd stable = stable_subspace(H, n);
  const Eigen::FullPivLU<MatrixXcd> top(stable.topRows(n).transpose());
  if (!top.isInvertible())
    throw std::runtime_error("no stabilising Riccati solution: (A, B) not stabilisable");
  MatrixXd X = symmetric(top.solve(stable.bottomRows(n).transpose()).transpose().real());
  double best = residual(A, G, Q, X);
  for (int i = 0; i < 3; ++i) {
    const MatrixXd newton = solve_lyapunov((A - G * X).transpose(), Q + X * G * X);
    const double next = residual(A, G, Q, newton);
    if (!(next < best)) break;
    X = newton;
    best = next;
  }
  if (!(best <= 1e-8)) {
    throw std::runtime_error("the Riccati solution does not satisfy its equation: badly scaled weights?");
  }
  if (!(Eigen::EigenSolver<MatrixXd>(A - G * X, false).eigenvalues().real().maxCoeff() < 0)) {
    throw std::runtime_error("the Riccati solution does not stabilise: (A, B) not stabilisable");
  }
  return X;
}

double care_residual(const MatrixXd& A, const MatrixXd& B, const MatrixXd& Q, const MatrixXd& R,
                     const MatrixXd& X) {
  return residual(A, B * R.llt().solve(B.transpose()), Q, X);
}

MatrixXd lqr(const MatrixXd& A, const MatrixXd& B, const MatrixXd& Q, const MatrixXd& R) {
  return R.llt().solve(B.transpose() * solve_care(A, B, Q, R));
}

MatrixXd solve_lyapunov(const MatrixXd& A, const MatrixXd& Q) {
  // With A = U T Uᴴ the equation is T Y + Y Tᴴ = −Uᴴ Q U, whose columns follow from the last to the first.
  const Index n = A.rows();
  const Eigen::ComplexSchur<MatrixXd> schur(A);
  const MatrixXcd& T = schur.matrixT();
  const MatrixXcd& U = schur.matrixU();
  const MatrixXcd C = -(U.adjoint() * Q * U);
  MatrixXcd Y(n, n);
  for (Index k = n - 1; k >= 0; --k) {
    VectorXcd right = C.col(k);
    for (Index j = k + 1; j < n; ++j) right -= Y.col(j) * std::conj(T(k, j));
    MatrixXcd shifted = T;
    shifted.diagonal().array() += std::conj(T(k, k));
    Y.col(k) = shifted.triangularView<Eigen::Upper>().solve(right);
  }
  return symmetric((U * Y * U.adjoint()).real());
}

}  // namespace motionlab::math
