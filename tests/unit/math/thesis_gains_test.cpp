// Every gain of the thesis, from its weights and back: thesis Sec 4.4 (2-D), 4.5 (3-D), 4.6 (motion system).
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <complex>
#include <vector>

#include "gateway/math/control_properties.hpp"
#include "gateway/math/riccati.hpp"
#include "gateway/math/rotation.hpp"
#include "tests/unit/math/golden.hpp"

namespace motionlab::math {
namespace {

using Eigen::MatrixXd;
using Eigen::RowVectorXd;
using Eigen::VectorXd;
using test::Json;

constexpr double kGravity = 9.81;

struct System {
  MatrixXd A, B;
};

/// x, x', theta, theta' (thesis Eq 4.21). Input: x''.
System planar(double L) {
  System s{MatrixXd::Zero(4, 4), MatrixXd::Zero(4, 1)};
  s.A(0, 1) = s.A(2, 3) = 1;
  s.A(3, 2) = -kGravity / L;
  s.B << 0, 1, 0, -1 / L;
  return s;
}

/// P, P', phi, phi' (3, 3, 2, 2). Input: P'' in the robot's axes, which R turns into those of the swing.
System spatial(double L, const Matrix3d& R = Matrix3d::Identity(), double beta_sign = -1) {
  System s{MatrixXd::Zero(10, 10), MatrixXd::Zero(10, 3)};
  s.A.block(0, 3, 3, 3).setIdentity();
  s.A.block(6, 8, 2, 2).setIdentity();
  s.A.block(8, 6, 2, 2) = -kGravity / L * Eigen::Matrix2d::Identity();
  s.B.block(3, 0, 3, 3).setIdentity();
  s.B.row(8) = R.row(0) / L;
  s.B.row(9) = beta_sign * R.row(1) / L;
  return s;
}

/// The integral of the first `outputs` states before the rest; sign −1 is Eq 4.63 as printed, +1 the code.
System with_integral(const System& s, int outputs, double sign) {
  const auto n = s.A.rows(), m = s.B.cols();
  System i{MatrixXd::Zero(n + outputs, n + outputs), MatrixXd::Zero(n + outputs, m)};
  i.A.block(0, outputs, outputs, outputs) = sign * MatrixXd::Identity(outputs, outputs);
  i.A.bottomRightCorner(n, n) = s.A;
  i.B.bottomRows(n) = s.B;
  return i;
}

MatrixXd gain(const System& s, const VectorXd& weights) {
  return lqr(s.A, s.B, weights.asDiagonal(), MatrixXd::Identity(s.B.cols(), s.B.cols()));
}

/// Weights of axes x, y, z and of alpha, beta in the order of the states.
VectorXd weights(std::initializer_list<double> values) {
  return VectorXd::Map(values.begin(), static_cast<Eigen::Index>(values.size()));
}
VectorXd blocks(std::initializer_list<std::pair<double, int>> runs) {
  std::vector<double> all;
  for (const auto& [value, count] : runs) all.insert(all.end(), static_cast<std::size_t>(count), value);
  return VectorXd::Map(all.data(), static_cast<Eigen::Index>(all.size()));
}

void expect_gain(const MatrixXd& K, const Json& golden) {
  EXPECT_LT((K - test::matrix(golden)).cwiseAbs().maxCoeff(),
            1e-6 * test::matrix(golden).cwiseAbs().maxCoeff());
}

std::vector<std::complex<double>> eigenvalues(const MatrixXd& A) {
  const Eigen::VectorXcd all = Eigen::EigenSolver<MatrixXd>(A, false).eigenvalues();
  return {all.data(), all.data() + all.size()};
}

/// Each golden eigenvalue has its own among ours. A k-fold one is only good to the k-th root of rounding,
/// hence the tolerance of repeated ones.
void expect_eigenvalues(const MatrixXd& A, const Json& golden, double tolerance = 1e-6) {
  auto left = eigenvalues(A);
  ASSERT_EQ(left.size(), golden.size());
  for (const auto& pair : golden) {
    const std::complex<double> expected(pair[0], pair[1]);
    const auto nearest = std::min_element(left.begin(), left.end(), [&](const auto& a, const auto& b) {
      return std::abs(a - expected) < std::abs(b - expected);
    });
    EXPECT_LT(std::abs(*nearest - expected), tolerance * (1 + std::abs(expected))) << expected;
    left.erase(nearest);
  }
}

/// How many printed entries the gain meets when it is rounded to the digits of the thesis.
int printed_entries_met(const MatrixXd& K, const MatrixXd& printed, double half_digit) {
  return static_cast<int>(((K - printed).cwiseAbs().array() <= half_digit).count());
}

class ThesisGains : public testing::Test {
 protected:
  const Json golden = test::golden("thesis_gains.json").at("gains");
  const Matrix3d raw =
      test::fixed<4, 4>(test::golden("thesis_platform.json").at("Hbr_printed")).topLeftCorner<3, 3>();
};

TEST_F(ThesisGains, OfThePlanarPendulumWithPrefilter) {
  const System s = planar(2);
  for (const auto& [name, q] : {std::pair("2D FPF text weights (4.23)", weights({1e3, 1e3, 1e5, 1e2})),
                                std::pair("2D FPF code weights", weights({100, 100, 1e4, 100}))}) {
    const MatrixXd K = gain(s, q);
    expect_gain(K, golden.at(name).at("computed"));
    expect_eigenvalues(s.A - s.B * K, golden.at(name).at("eig"));
    MatrixXd C = MatrixXd::Zero(1, 4);
    C(0, 0) = 1;
    expect_gain((C * (s.B * K - s.A).inverse() * s.B).inverse(), golden.at(name).at("N"));
  }
  // The text's weights are not behind the printed gain (4.24); the code's are.
  const MatrixXd printed = test::matrix(golden.at("2D FPF code weights").at("printed"));
  EXPECT_EQ(printed_entries_met(gain(s, weights({1e3, 1e3, 1e5, 1e2})), printed, 0.0056), 0);
  EXPECT_EQ(printed_entries_met(gain(s, weights({100, 100, 1e4, 100})), printed, 0.0056), 4);
  expect_eigenvalues(s.A - s.B * printed, golden.at("2D FPF printed K eig"));
}

TEST_F(ThesisGains, OfThePlanarPendulumWithIntegral) {
  for (const auto& [name, sign, q] :
       {std::tuple("2D IC text weights (4.34), -C", -1.0, weights({1e3, 1e3, 1e3, 1e5, 1e2})),
        std::tuple("2D IC code weights, -C", -1.0, weights({1e3, 1e3, 1e2, 1e5, 1e2})),
        std::tuple("2D IC code weights, +C (sign as printed)", 1.0, weights({1e3, 1e3, 1e2, 1e5, 1e2})),
        std::tuple("2D IC text weights, +C", 1.0, weights({1e3, 1e3, 1e3, 1e5, 1e2}))}) {
    const System s = with_integral(planar(2), 1, sign);
    const MatrixXd K = gain(s, q);
    expect_gain(K, golden.at(name).at("computed"));
    expect_eigenvalues(s.A - s.B * K, golden.at(name).at("eig"));
  }
}

TEST_F(ThesisGains, OfTheSuspendedLoadWithPrefilter) {
  const System s = spatial(2);
  const MatrixXd C = MatrixXd::Identity(3, 10);
  const MatrixXd text = gain(s, blocks({{1e3, 3}, {1e2, 3}, {1e4, 2}, {1e3, 2}}));
  expect_gain(text, golden.at("3D FPF").at("computed"));
  expect_gain((C * (s.B * text - s.A).inverse() * s.B).inverse(), golden.at("3D FPF").at("N"));
  expect_eigenvalues(s.A - s.B * text, golden.at("3D FPF").at("eig"), 1e-5);
  expect_eigenvalues(s.A - s.B * test::matrix(golden.at("3D FPF").at("printed")),
                     golden.at("3D FPF").at("eig_printed"));

  // The weights behind the printed rows: P 1e3, 1e2, 1e3; v 1e2, 1e3, 1e2; phi 1e4, 1e3; phi' 1e4, 1e3.
  const MatrixXd recovered = gain(s, weights({1e3, 1e2, 1e3, 1e2, 1e3, 1e2, 1e4, 1e3, 1e4, 1e3}));
  expect_gain(recovered, golden.at("3D FPF recovered weights").at("computed"));
  expect_eigenvalues(s.A - s.B * recovered, golden.at("3D FPF recovered weights").at("eig"));
  EXPECT_EQ(printed_entries_met(recovered, test::matrix(golden.at("3D FPF").at("printed")), 0.0051), 30);

  const System longer = spatial(6);
  expect_eigenvalues(longer.A - longer.B * text, golden.at("3D FPF text gains on L=6 eig"), 1e-5);
  expect_eigenvalues(longer.A - longer.B * test::matrix(golden.at("3D FPF").at("printed")),
                     golden.at("3D FPF printed gains on L=6 eig"));
}

TEST_F(ThesisGains, OfTheSuspendedLoadWithIntegral) {
  const System s = with_integral(spatial(2), 3, +1);
  const VectorXd q = blocks({{1e3, 6}, {1e2, 3}, {1e4, 2}, {1e3, 2}});
  const MatrixXd text = gain(s, q);
  expect_gain(text, golden.at("3D IC").at("computed"));
  expect_eigenvalues(s.A - s.B * text, golden.at("3D IC").at("eig"), 1e-5);
  expect_eigenvalues(s.A - s.B * test::matrix(golden.at("3D IC").at("printed")),
                     golden.at("3D IC").at("eig_printed"));

  const System minus = with_integral(spatial(2), 3, -1);
  const MatrixXd mirrored = gain(minus, q);
  expect_gain(mirrored, golden.at("3D IC with -C (Eq 4.63)").at("computed"));
  expect_eigenvalues(minus.A - minus.B * mirrored, golden.at("3D IC with -C (Eq 4.63)").at("eig"), 1e-5);

  const MatrixXd recovered =
      gain(s, weights({1e3, 1e3, 1e3, 1e3, 1e2, 1e3, 1e2, 1e3, 1e2, 1e4, 1e3, 1e4, 1e3}));
  expect_gain(recovered, golden.at("3D IC recovered weights").at("computed"));
  expect_eigenvalues(s.A - s.B * recovered, golden.at("3D IC recovered weights").at("eig"), 1e-5);
  EXPECT_EQ(printed_entries_met(recovered, test::matrix(golden.at("3D IC").at("printed")), 0.0051), 38);

  const System longer = with_integral(spatial(6), 3, +1);
  expect_eigenvalues(longer.A - longer.B * text, golden.at("3D IC text gains on L=6 eig"), 1e-5);
  expect_eigenvalues(longer.A - longer.B * test::matrix(golden.at("3D IC").at("printed")),
                     golden.at("3D IC printed gains on L=6 eig"));
}

TEST_F(ThesisGains, OfTheMotionSystem) {
  const VectorXd code = blocks({{1e4, 3}, {1e3, 3}, {1e2, 3}, {1e4, 2}, {1e3, 2}});
  const VectorXd text = blocks({{1e3, 6}, {1e2, 3}, {1e4, 2}, {1e3, 2}});
  const Matrix3d projected = nearest_rotation(raw);
  for (const auto& [name, R, q] : {std::tuple("motion IC code weights, raw Rbr", raw, code),
                                   std::tuple("motion IC code weights, projected Rbr", projected, code),
                                   std::tuple("motion IC text weights, raw Rbr", raw, text)}) {
    const System s = with_integral(spatial(2, R), 3, +1);
    const MatrixXd K = gain(s, q);
    expect_gain(K.leftCols(3), golden.at(name).at("Ki"));
    expect_gain(K.rightCols(10), golden.at(name).at("Ko"));
    expect_eigenvalues(s.A - s.B * K, golden.at(name).at("eig"), 1e-5);
  }
  const System feedback = spatial(2, raw);
  const MatrixXd K = gain(feedback, blocks({{1e4, 3}, {1e2, 3}, {1e4, 2}, {1e3, 2}}));
  expect_gain(K, golden.at("motion state feedback (code Q_LQR)").at("K"));
  expect_eigenvalues(feedback.A - feedback.B * K, golden.at("motion state feedback (code Q_LQR)").at("eig"),
                     1e-5);

  const System upright = with_integral(spatial(2), 3, +1);
  const MatrixXd same = gain(upright, code);
  expect_gain(same, golden.at("3D IC with motion weights").at("K"));
  expect_eigenvalues(upright.A - upright.B * same, golden.at("3D IC with motion weights").at("eig"), 1e-5);
}

TEST_F(ThesisGains, OfTheMotionSystemInWorldAxesHaveTheBetaColumnsTurned) {
  const VectorXd code = blocks({{1e4, 3}, {1e3, 3}, {1e2, 3}, {1e4, 2}, {1e3, 2}});
  const Matrix3d R = nearest_rotation(raw);
  const MatrixXd thesis = gain(with_integral(spatial(2, R, -1), 3, +1), code);
  MatrixXd world = gain(with_integral(spatial(2, R, +1), 3, +1), code);
  world.col(10) *= -1;
  world.col(12) *= -1;
  EXPECT_LT((world - thesis).norm(), 1e-9 * thesis.norm());
}

TEST_F(ThesisGains, OfTheMotionSystemBarelyFeelTheRoundingOfTheCalibration) {
  const VectorXd code = blocks({{1e4, 3}, {1e3, 3}, {1e2, 3}, {1e4, 2}, {1e3, 2}});
  const MatrixXd K_raw = gain(with_integral(spatial(2, raw), 3, +1), code);
  const MatrixXd K_projected = gain(with_integral(spatial(2, nearest_rotation(raw)), 3, +1), code);
  EXPECT_NEAR((K_projected - K_raw).cwiseAbs().maxCoeff(),
              golden.at("motion IC: gain change raw -> projected").get<double>(), 1e-6);
  // Rounding of the four printed digits, entry by entry.
  double largest = 0;
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j < 3; ++j) {
      for (const double half_digit : {-5e-5, 5e-5}) {
        Matrix3d moved = raw;
        moved(i, j) += half_digit;
        const MatrixXd K = gain(with_integral(spatial(2, moved), 3, +1), code);
        largest = std::max(largest, (K - K_raw).cwiseAbs().maxCoeff());
      }
    }
  }
  const double published = golden.at("motion IC: gain change for Hbr rounding +-5e-5");
  EXPECT_NEAR(largest, published, 0.05 * published) << "theirs is the largest of random roundings";
}

TEST_F(ThesisGains, GiveTheirWeightsBack) {
  const auto expect = [&](const char* name, const System& s, const RowVectorXd& k) {
    const auto found = recover_weights(s.A, s.B.col(0), k);
    const VectorXd expected = test::matrix(golden.at(name).at("Q"));
    EXPECT_LT(((found.q - expected).array() / expected.array()).abs().maxCoeff(), 1e-6) << name;
    EXPECT_LT(found.fit, 1e-9) << name;
  };
  expect("2D FPF inverse LQR of printed K", planar(2),
         test::matrix(golden.at("2D FPF code weights").at("printed")));
  expect("2D IC inverse LQR of printed K", with_integral(planar(2), 1, +1),
         test::matrix(golden.at("2D IC code weights, -C").at("printed")));

  // One axis of the 3-D system: P, v (and swing, which x drives forward and y backward).
  const System x{planar(2).A, (MatrixXd(4, 1) << 0, 1, 0, 0.5).finished()};
  const System y = planar(2);
  const System z{(MatrixXd(2, 2) << 0, 1, 0, 0).finished(), (MatrixXd(2, 1) << 0, 1).finished()};
  const MatrixXd fpf = test::matrix(golden.at("3D FPF").at("printed")),
                 ic = test::matrix(golden.at("3D IC").at("printed"));
  const auto row = [](const MatrixXd& K, int axis, const std::vector<int>& columns) {
    RowVectorXd k(static_cast<Eigen::Index>(columns.size()));
    for (std::size_t i = 0; i < columns.size(); ++i) k[static_cast<Eigen::Index>(i)] = K(axis, columns[i]);
    return k;
  };
  expect("3D FPF inverse LQR row x", x, row(fpf, 0, {0, 3, 6, 8}));
  expect("3D FPF inverse LQR row y", y, row(fpf, 1, {1, 4, 7, 9}));
  expect("3D FPF inverse LQR row z", z, row(fpf, 2, {2, 5}));
  expect("3D IC inverse LQR row x", with_integral(x, 1, +1), row(ic, 0, {0, 3, 6, 9, 11}));
  expect("3D IC inverse LQR row y", with_integral(y, 1, +1), row(ic, 1, {1, 4, 7, 10, 12}));
  expect("3D IC inverse LQR row z", with_integral(z, 1, +1), row(ic, 2, {2, 5, 8}));
}

TEST_F(ThesisGains, VirtualDamperOfThePlaneIsStableOnlyWithTheCorrectedSign) {
  // Eq 4.39/4.40 as printed drive the swing: u = −L d theta'; corrected: +.
  for (const double sign : {-1.0, +1.0}) {
    const System s = planar(2);
    const Eigen::RowVector4d u(-0.2, -0.85, 0, sign * 2 * 5);
    const MatrixXd A = s.A + s.B * u;
    expect_eigenvalues(A, golden.at(sign < 0 ? "2D virtual damper d=5 PD 0.2/0.85, sign -1"
                                             : "2D virtual damper d=5 PD 0.2/0.85, sign +1"));
    const double rightmost = Eigen::EigenSolver<MatrixXd>(A, false).eigenvalues().real().maxCoeff();
    EXPECT_EQ(rightmost<0, sign> 0);
  }
}

/// The cascade of Tab 4.5 with a virtual damper (Eq 4.73/4.74), linearised: x, x', phi, phi', ∫e, x_f.
MatrixXd cascade(bool x_axis, double L, double L_damper) {
  const double N = 100;
  const double Kp_v = x_axis ? 4.786 : 1.002, Kd_v = x_axis ? 3.324 : 0.408;
  const double Kp = x_axis ? 0.577 : 0.788, Ki = x_axis ? 0.103 : 0.072;
  const double d = x_axis ? 7 : 5, drive = x_axis ? 1 : -1;
  using Row = Eigen::Matrix<double, 1, 6>;
  const Row x = Row::Unit(0), v = Row::Unit(1), phi = Row::Unit(2), phi_dot = Row::Unit(3),
            integral = Row::Unit(4), x_f = Row::Unit(5);
  const Row e_v = -Kp * x + Ki * integral - v;
  const Row a = Kp_v * e_v + Kd_v * N * (e_v - x_f) - drive * d * L_damper * phi_dot;
  MatrixXd A(6, 6);
  A << v, a, phi_dot, drive * a / L - kGravity / L * phi, -x, N * (e_v - x_f);
  return A;
}

TEST_F(ThesisGains, CascadeWithVirtualDamperHasTheGoldenEigenvalues) {
  for (const auto& [name, x_axis, L, L_damper] :
       {std::tuple("NL cascade x L=2.0 damper L=2.0 N=100.0", true, 2.0, 2.0),
        std::tuple("NL cascade y L=2.0 damper L=2.0 N=100.0", false, 2.0, 2.0),
        std::tuple("NL cascade x L=6.0 damper L=2.0 N=100.0", true, 6.0, 2.0),
        std::tuple("NL cascade x L=6.0 damper L=6.0 N=100.0", true, 6.0, 6.0),
        std::tuple("NL cascade y L=6.0 damper L=2.0 N=100.0", false, 6.0, 2.0),
        std::tuple("NL cascade y L=6.0 damper L=6.0 N=100.0", false, 6.0, 6.0)}) {
    expect_eigenvalues(cascade(x_axis, L, L_damper), golden.at(name));
  }
}

TEST_F(ThesisGains, EveryModelIsControllable) {
  EXPECT_EQ(controllability_rank(planar(2).A, planar(2).B), 4);
  const System s = with_integral(spatial(2, raw), 3, +1);
  EXPECT_EQ(controllability_rank(s.A, s.B), 13);
  EXPECT_LT(care_residual(s.A, s.B, MatrixXd::Identity(13, 13), MatrixXd::Identity(3, 3),
                          solve_care(s.A, s.B, MatrixXd::Identity(13, 13), MatrixXd::Identity(3, 3))),
            1e-13);
}

}  // namespace
}  // namespace motionlab::math
