#include "gateway/controller/thesis_gains.hpp"

#include <Eigen/LU>

#include "gateway/math/riccati.hpp"

namespace motionlab::controller {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kGravity = 9.81;
constexpr double kWire = 2.0;

/// Weights of the load's states; swing weights are (alpha, beta).
struct LoadWeights {
  Vector3d z{0, 0, 0};
  Vector3d position{1e3, 1e3, 1e3};
  Vector3d velocity{1e2, 1e2, 1e2};
  Vector2d angle{1e4, 1e4};
  Vector2d rate{1e3, 1e3};
};

/// The plain LQR gain under unit weight on every input.
MatrixXd regulator(const MatrixXd& A, const MatrixXd& B, const VectorXd& weights) {
  return math::lqr(A, B, weights.asDiagonal(), MatrixXd::Identity(B.cols(), B.cols()));
}

/// The gain [Kz K] of the system with z' = C x before its states.
MatrixXd integral_regulator(const MatrixXd& A, const MatrixXd& B, const MatrixXd& C,
                            const VectorXd& weights) {
  const Eigen::Index n = A.rows(), m = C.rows();
  MatrixXd Ai = MatrixXd::Zero(n + m, n + m), Bi = MatrixXd::Zero(n + m, B.cols());
  Ai.topRightCorner(m, n) = C;
  Ai.bottomRightCorner(n, n) = A;
  Bi.bottomRows(n) = B;
  return regulator(Ai, Bi, weights);
}

/// N that lets y = C x come to r at rest (Eq 3.122).
MatrixXd prefilter(const MatrixXd& A, const MatrixXd& B, const MatrixXd& C, const MatrixXd& K) {
  const MatrixXd closed = B * K - A;
  return (C * closed.partialPivLu().solve(B)).inverse();
}

Eigen::Matrix<double, 3, 10> tool_position() {
  Eigen::Matrix<double, 3, 10> C = Eigen::Matrix<double, 3, 10>::Zero();
  C.leftCols<3>().setIdentity();
  return C;
}

/// What the x and y rows of Eq 4.59 and 4.69 were really computed with: x asks for still swing rates, y for
/// little speed. Undocumented; found by inverse LQR, which is exact for one input.
LoadWeights recovered() {
  LoadWeights w;
  w.position.y() = 1e2;
  w.velocity.y() = 1e3;
  w.angle = {1e4, 1e3};
  w.rate = {1e4, 1e3};
  return w;
}

ThesisLoadIntegralGain load_integral(const LoadWeights& w, const Matrix3d& R_WR) {
  Eigen::Matrix<double, 13, 1> weights;
  weights << w.z, w.position, w.velocity, w.angle, w.rate;
  const MatrixXd K = integral_regulator(thesis_load_A(), thesis_load_B(R_WR), tool_position(), weights);
  return {K.leftCols<3>(), K.rightCols<10>()};
}

}  // namespace

Eigen::Matrix4d thesis_pendulum_A() {
  Eigen::Matrix4d A = Eigen::Matrix4d::Zero();
  A(0, 1) = A(2, 3) = 1;
  A(3, 2) = -kGravity / kWire;
  return A;
}

Eigen::Vector4d thesis_pendulum_B() {
  return {0, 1, 0, -1 / kWire};
}

Eigen::Matrix<double, 10, 10> thesis_load_A(double wire_length_m) {
  Eigen::Matrix<double, 10, 10> A = Eigen::Matrix<double, 10, 10>::Zero();
  A.block<3, 3>(0, 3).setIdentity();
  A.block<2, 2>(6, 8).setIdentity();
  A(8, 6) = A(9, 7) = -kGravity / wire_length_m;
  return A;
}

Eigen::Matrix<double, 10, 3> thesis_load_B(const Matrix3d& R_WR, double wire_length_m) {
  Eigen::Matrix<double, 10, 3> B = Eigen::Matrix<double, 10, 3>::Zero();
  B.block<3, 3>(3, 0).setIdentity();
  B.row(8) = R_WR.row(0) / wire_length_m;   // L alpha'' = +x''
  B.row(9) = -R_WR.row(1) / wire_length_m;  // L beta'' = −y''
  return B;
}

ThesisPendulumPrefilterGain thesis_pendulum_prefilter(ThesisWeights which) {
  Eigen::Vector4d weights(1e2, 1e2, 1e4, 1e2);
  if (which == ThesisWeights::text) weights << 1e3, 1e3, 1e5, 1e2;
  const MatrixXd A = thesis_pendulum_A(), B = thesis_pendulum_B(), C = Eigen::RowVector4d::Unit(0);
  const MatrixXd K = regulator(A, B, weights);
  return {K, prefilter(A, B, C, K)(0, 0)};
}

ThesisPendulumIntegralGain thesis_pendulum_integral(ThesisWeights which) {
  Eigen::Matrix<double, 5, 1> weights;
  weights << 1e3, 1e3, (which == ThesisWeights::text ? 1e3 : 1e2), 1e5, 1e2;
  const MatrixXd C = Eigen::RowVector4d::Unit(0);
  const MatrixXd K = integral_regulator(thesis_pendulum_A(), thesis_pendulum_B(), C, weights);
  return {K(0, 0), K.rightCols<4>()};
}

ThesisLoadPrefilterGain thesis_load_prefilter(ThesisWeights which) {
  const LoadWeights w = which == ThesisWeights::printed ? recovered() : LoadWeights{};
  Eigen::Matrix<double, 10, 1> weights;
  weights << w.position, w.velocity, w.angle, w.rate;
  const MatrixXd A = thesis_load_A(), B = thesis_load_B(Matrix3d::Identity());
  const MatrixXd K = regulator(A, B, weights);
  return {K, prefilter(A, B, tool_position(), K)};
}

ThesisLoadIntegralGain thesis_load_integral(ThesisWeights which) {
  LoadWeights w = which == ThesisWeights::printed ? recovered() : LoadWeights{};
  w.z.setConstant(1e3);
  return load_integral(w, Matrix3d::Identity());
}

ThesisLoadIntegralGain thesis_motion_integral(ThesisWeights which, const Matrix3d& R_WR) {
  LoadWeights w;
  w.z.setConstant(which == ThesisWeights::text ? 1e3 : 1e4);
  return load_integral(w, R_WR);
}

}  // namespace motionlab::controller
