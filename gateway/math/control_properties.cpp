#include "gateway/math/control_properties.hpp"

#include <Eigen/LU>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <cmath>
#include <complex>

namespace motionlab::math {

using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::RowVectorXd;
using Eigen::VectorXcd;
using Eigen::VectorXd;

MatrixXd controllability_matrix(const MatrixXd& A, const MatrixXd& B) {
  const Index n = A.rows(), m = B.cols();
  MatrixXd K(n, n * m);
  MatrixXd block = B;
  for (Index i = 0; i < n; ++i, block = A * block) K.middleCols(i * m, m) = block;
  return K;
}

MatrixXd reachable_space(const MatrixXd& A, const MatrixXd& B, double tolerance) {
  const Index n = A.rows();
  MatrixXd basis(n, 0);
  MatrixXd block = B;
  double scale = B.norm();
  while (block.cols() > 0 && basis.cols() < n) {
    // Twice, because once leaves rounding of the size of what was taken away.
    block -= basis * (basis.transpose() * block);
    block -= basis * (basis.transpose() * block);
    const Eigen::JacobiSVD<MatrixXd> svd(block, Eigen::ComputeThinU);
    const Index fresh = (svd.singularValues().array() > tolerance * scale).count();
    const MatrixXd added = svd.matrixU().leftCols(fresh);
    const Index old = basis.cols();
    basis.conservativeResize(Eigen::NoChange, old + fresh);
    basis.rightCols(fresh) = added;
    block = A * added;
    scale = A.norm();
  }
  return basis;
}

int controllability_rank(const MatrixXd& A, const MatrixXd& B, double tolerance) {
  return static_cast<int>(reachable_space(A, B, tolerance).cols());
}

int observability_rank(const MatrixXd& A, const MatrixXd& C, double tolerance) {
  return controllability_rank(A.transpose(), C.transpose(), tolerance);
}

MatrixXd unobservable_space(const MatrixXd& A, const MatrixXd& C, double tolerance) {
  const MatrixXd seen = reachable_space(A.transpose(), C.transpose(), tolerance);
  const Eigen::JacobiSVD<MatrixXd> svd(seen, Eigen::ComputeFullU);
  return svd.matrixU().rightCols(A.rows() - seen.cols());
}

RecoveredWeights recover_weights(const MatrixXd& A, const VectorXd& b, const RowVectorXd& k) {
  const Index n = A.rows(), rows = 6 * n;
  // Frequencies about those of the closed loop, and away from poles on the imaginary axis.
  const double middle = std::pow(std::abs((A - b * k).determinant()), 1.0 / static_cast<double>(n));
  MatrixXd M(rows, n);
  VectorXd right(rows);
  for (Index i = 0; i < rows; ++i) {
    const double place = static_cast<double>(i) / static_cast<double>(rows - 1);
    const std::complex<double> s(0, middle * std::pow(100.0, 2 * place - 1));
    const MatrixXcd sI_A = s * MatrixXcd::Identity(n, n) - A.cast<std::complex<double>>();
    const VectorXcd x = sI_A.partialPivLu().solve(b.cast<std::complex<double>>());
    const double loop = std::norm(1.0 + (k.cast<std::complex<double>>() * x)(0));
    // Each row relative to the size of its terms, so that every frequency has its say.
    M.row(i) = x.cwiseAbs2().transpose() / (loop + 1);
    right[i] = (loop - 1) / (loop + 1);
  }
  const RowVectorXd size = M.colwise().norm();
  const MatrixXd scaled = M * size.cwiseInverse().asDiagonal();
  const VectorXd y = scaled.colPivHouseholderQr().solve(right);
  return {size.cwiseInverse().transpose().cwiseProduct(y), (scaled * y - right).norm() / right.norm()};
}

}  // namespace motionlab::math
