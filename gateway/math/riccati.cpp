#include "gateway/math/riccati.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <complex>
#include <stdexcept>

namespace motionlab::math {

using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd solve_care(const MatrixXd& A, const MatrixXd& B, const MatrixXd& Q, const MatrixXd& R) {
  const Eigen::Index n = A.rows();
  const MatrixXd G = B * R.llt().solve(B.transpose());
  MatrixXd H(2 * n, 2 * n);
  H << A, -G, -Q, -A.transpose();
  const Eigen::EigenSolver<MatrixXd> eigen(H);
  MatrixXcd stable(2 * n, n);
  Eigen::Index found = 0;
  for (Eigen::Index i = 0; i < 2 * n && found < n; ++i) {
    if (eigen.eigenvalues()[i].real() < 0) stable.col(found++) = eigen.eigenvectors().col(i);
  }
  if (found < n)
    throw std::runtime_error("no stabilising Riccati solution: check stabilisability and detectability");
  const MatrixXcd X =
      stable.topRows(n).transpose().fullPivLu().solve(stable.bottomRows(n).transpose()).transpose();
  const MatrixXd solution = 0.5 * (X.real() + X.real().transpose());
  const MatrixXd residual = A.transpose() * solution + solution * A - solution * G * solution + Q;
  if (!(residual.norm() <= 1e-8 * (1 + Q.norm() + solution.norm()))) {
    throw std::runtime_error("the Riccati solution does not satisfy its equation: badly scaled weights?");
  }
  return solution;
}

MatrixXd lqr(const MatrixXd& A, const MatrixXd& B, const MatrixXd& Q, const MatrixXd& R) {
  return R.llt().solve(B.transpose() * solve_care(A, B, Q, R));
}

MatrixXd solve_lyapunov(const MatrixXd& A, const MatrixXd& Q) {
  const Eigen::Index n = A.rows();
  MatrixXd K = MatrixXd::Zero(n * n, n * n);
  for (Eigen::Index i = 0; i < n; ++i) {
    K.block(i * n, i * n, n, n) += A;
    for (Eigen::Index j = 0; j < n; ++j) {
      K.block(i * n, j * n, n, n) += A(i, j) * MatrixXd::Identity(n, n);
    }
  }
  const VectorXd x = K.partialPivLu().solve(-VectorXd::Map(Q.data(), n * n));
  return MatrixXd::Map(x.data(), n, n);
}

}  // namespace motionlab::math
