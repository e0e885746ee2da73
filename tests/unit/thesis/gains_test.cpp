/// Every gain of the thesis against an independent computation, and the closed loops they make.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <complex>
#include <vector>

#include "gateway/controller/thesis_laws.hpp"
#include "gateway/estimator/thesis_ekf35.hpp"
#include "simulators/lab/thesis/simulation.hpp"
#include "simulators/plant/thesis_crane.hpp"
#include "tests/unit/thesis/golden.hpp"

namespace motionlab::thesis {
namespace {

using namespace controller;
using Eigen::MatrixXd;

constexpr double kSame = 1e-6;

const nlohmann::json& gain(const std::string& name) {
  return golden("gains")["gains"][name];
}

MatrixXd side_by_side(const MatrixXd& left, const MatrixXd& right) {
  MatrixXd both(left.rows(), left.cols() + right.cols());
  both << left, right;
  return both;
}

TEST(ThesisGains, OfThePendulumsPrefilterAreTheReferences) {
  const auto text = thesis_pendulum_prefilter(ThesisWeights::text);
  expect_close(text.K, matrix(gain("2D FPF text weights (4.23)")["computed"]), kSame, "text");
  for (const auto weights : {ThesisWeights::code, ThesisWeights::printed}) {
    const auto code = thesis_pendulum_prefilter(weights);
    expect_close(code.K, matrix(gain("2D FPF code weights")["computed"]), kSame, "code");
    EXPECT_NEAR(code.N, 10.0, 1e-6);
  }
}

TEST(ThesisGains, OfThePendulumsIntegralAreTheReferences) {
  const auto text = thesis_pendulum_integral(ThesisWeights::text);
  expect_close(side_by_side(MatrixXd::Constant(1, 1, text.Kz), text.K),
               matrix(gain("2D IC text weights, +C")["computed"]), kSame, "text");
  for (const auto weights : {ThesisWeights::code, ThesisWeights::printed}) {
    const auto code = thesis_pendulum_integral(weights);
    expect_close(side_by_side(MatrixXd::Constant(1, 1, code.Kz), code.K),
                 matrix(gain("2D IC code weights, +C (sign as printed)")["computed"]), kSame, "code");
  }
}

TEST(ThesisGains, OfTheLoadsPrefilterAreTheReferences) {
  for (const auto weights : {ThesisWeights::text, ThesisWeights::code}) {
    const auto text = thesis_load_prefilter(weights);
    expect_close(text.K, matrix(gain("3D FPF")["computed"]), kSame, "text");
    expect_close(text.N, matrix(gain("3D FPF")["N"]), kSame, "N");
  }
  const auto printed = thesis_load_prefilter(ThesisWeights::printed);
  expect_close(printed.K, matrix(gain("3D FPF recovered weights")["computed"]), kSame, "recovered");
  EXPECT_LE((printed.K - matrix(gain("3D FPF")["printed"])).cwiseAbs().maxCoeff(), 0.005);  // all digits
  const Eigen::Vector3d N(31.62, 10.0, 31.62);                                              // Eq 4.60
  EXPECT_LE((printed.N - MatrixXd(N.asDiagonal())).cwiseAbs().maxCoeff(), 0.005);
}

TEST(ThesisGains, OfTheLoadsIntegralAreTheReferences) {
  for (const auto weights : {ThesisWeights::text, ThesisWeights::code}) {
    const auto text = thesis_load_integral(weights);
    expect_close(side_by_side(text.Kz, text.K), matrix(gain("3D IC")["computed"]), kSame, "text");
  }
  const auto printed = thesis_load_integral(ThesisWeights::printed);
  expect_close(side_by_side(printed.Kz, printed.K), matrix(gain("3D IC recovered weights")["computed"]),
               kSame, "recovered");
}

TEST(ThesisGains, OfTheMotionSystemAreTheReferences) {
  const Eigen::Matrix3d raw = estimator::thesis_R_BR_as_printed();
  const Eigen::Matrix3d projected = matrix(golden("gains")["R_BR_projected"]);
  const auto check = [](const ThesisLoadIntegralGain& ours, const std::string& name) {
    expect_close(ours.Kz, matrix(gain(name)["Ki"]), kSame, name);
    expect_close(ours.K, matrix(gain(name)["Ko"]), kSame, name);
  };
  check(thesis_motion_integral(ThesisWeights::code, raw), "motion IC code weights, raw Rbr");
  check(thesis_motion_integral(ThesisWeights::printed, raw), "motion IC code weights, raw Rbr");
  check(thesis_motion_integral(ThesisWeights::code, projected), "motion IC code weights, projected Rbr");
  check(thesis_motion_integral(ThesisWeights::text, raw), "motion IC text weights, raw Rbr");
}

TEST(ThesisGains, OfTheMotionSystemInTheWorldTurnTheSignOfBeta) {
  const estimator::ThesisEkf35Config belief;
  expect_close(belief.R_BR, matrix(golden("gains")["R_BR_projected"]), 1e-12, "R_BR");
  const auto in_N = thesis_motion_integral(ThesisWeights::code, belief.R_BR);
  const auto in_W = thesis_motion_integral(ThesisWeights::code, belief.R_WN * belief.R_BR);
  MatrixXd turned = in_N.K;
  turned.col(7) *= -1;
  turned.col(9) *= -1;
  expect_close(in_W.K, turned, kSame, "K");
  expect_close(in_W.Kz, in_N.Kz, kSame, "Kz");
}

/// Eigenvalues by real part, then imaginary part.
std::vector<std::complex<double>> poles(const MatrixXd& A) {
  const Eigen::VectorXcd values = Eigen::EigenSolver<MatrixXd>(A).eigenvalues();
  std::vector<std::complex<double>> sorted(values.begin(), values.end());
  std::sort(sorted.begin(), sorted.end(), [](auto a, auto b) {
    return std::abs(a.real() - b.real()) > 1e-6 ? a.real() < b.real() : a.imag() < b.imag();
  });
  return sorted;
}

void expect_poles(const MatrixXd& A, const nlohmann::json& reference, const std::string& what) {
  const auto ours = poles(A);
  ASSERT_EQ(ours.size(), reference.size()) << what;
  std::vector<std::complex<double>> expected;
  for (const auto& pole : reference) expected.emplace_back(pole[0].get<double>(), pole[1].get<double>());
  for (const auto& pole : ours) {  // each of ours has its like there; double poles are known to 1e-6 only
    double nearest = 1e9;
    for (const auto& other : expected) nearest = std::min(nearest, std::abs(pole - other));
    EXPECT_LE(nearest, 1e-5 * (1 + std::abs(pole))) << what << ": " << pole;
  }
}

/// d/dt of (state, memory) by itself in a linear loop of a law, by differences: laws are linear about rest.
template <class Law, int N, int M, int Memories>
MatrixXd closed_loop(const Law& law, const Eigen::Matrix<double, N, N>& A,
                     const Eigen::Matrix<double, N, M>& B) {
  constexpr int kAll = N + Memories;
  MatrixXd loop(kAll, kAll);
  for (int i = 0; i < kAll; ++i) {
    const auto rate = [&](double d) {
      Eigen::Matrix<double, kAll, 1> both = Eigen::Matrix<double, kAll, 1>::Zero();
      both[i] = d;
      const typename Law::State x = both.template head<N>();
      const typename Law::Memory memory = both.template tail<Memories>();
      const typename Law::Input r = Law::Input::Zero();
      Eigen::Matrix<double, kAll, 1> result;
      result << A * x + B * law.command(x, memory, r), law.memory_rate(x, memory, r);
      return result;
    };
    loop.col(i) = (rate(1e-6) - rate(-1e-6)) / 2e-6;
  }
  return loop;
}

/// The same without a memory that the law does not use.
MatrixXd without(const MatrixXd& loop, Eigen::Index memories) {
  const Eigen::Index n = loop.rows() - memories;
  return loop.topLeftCorner(n, n);
}

TEST(ThesisLaws, MakeTheReferencesPolesOnThePendulum) {
  const Eigen::Matrix4d A = thesis_pendulum_A();
  const Eigen::Vector4d B = thesis_pendulum_B();
  const ThesisPendulumPrefilter prefilter(thesis_pendulum_prefilter(ThesisWeights::code));
  expect_poles(without(closed_loop<ThesisPendulumLaw, 4, 1, 1>(prefilter, A, B), 1),
               gain("2D FPF code weights")["eig"], "pre-filter");
  const ThesisPendulumIntegral integral(thesis_pendulum_integral(ThesisWeights::code));
  expect_poles(closed_loop<ThesisPendulumLaw, 4, 1, 1>(integral, A, B),
               gain("2D IC code weights, +C (sign as printed)")["eig"], "integral");
  const ThesisPendulumDamper damper;
  expect_poles(without(closed_loop<ThesisPendulumLaw, 4, 1, 1>(damper, A, B), 1),
               gain("2D virtual damper d=5 PD 0.2/0.85, sign +1"), "damper");
  ThesisPendulumDamperConfig as_printed;
  as_printed.damping_per_s = -5;
  const ThesisPendulumDamper unstable(as_printed);
  expect_poles(without(closed_loop<ThesisPendulumLaw, 4, 1, 1>(unstable, A, B), 1),
               gain("2D virtual damper d=5 PD 0.2/0.85, sign -1"), "damper as printed");
}

TEST(ThesisLaws, MakeTheReferencesPolesOnTheLoad) {
  for (const double wire : {2.0, 6.0}) {
    const auto A = thesis_load_A(wire);
    const auto B = thesis_load_B(Eigen::Matrix3d::Identity(), wire);
    for (const auto weights : {ThesisWeights::text, ThesisWeights::printed}) {
      const std::string set = weights == ThesisWeights::text ? "text" : "printed";
      const ThesisLoadPrefilter prefilter(thesis_load_prefilter(weights));
      const ThesisLoadIntegral integral(thesis_load_integral(weights));
      const MatrixXd with_prefilter = without(closed_loop<ThesisLoadLaw, 10, 3, 4>(prefilter, A, B), 4);
      const MatrixXd with_integral = without(closed_loop<ThesisLoadLaw, 10, 3, 4>(integral, A, B), 1);
      if (wire == 2.0) {
        const std::string suffix = weights == ThesisWeights::text ? "" : " recovered weights";
        expect_poles(with_prefilter, gain("3D FPF" + suffix)["eig"], "pre-filter, " + set);
        expect_poles(with_integral, gain("3D IC" + suffix)["eig"], "integral, " + set);
      } else if (weights == ThesisWeights::text) {
        expect_poles(with_prefilter, gain("3D FPF text gains on L=6 eig"), "pre-filter on 6 m");
        expect_poles(with_integral, gain("3D IC text gains on L=6 eig"), "integral on 6 m");
      }
    }
  }
}

TEST(ThesisLaws, PutTheCascadeOnTheVergeOfInstabilityOnSixMetres) {
  for (const double wire : {2.0, 6.0}) {
    for (const double believed : {2.0, 6.0}) {
      if (believed > wire) continue;
      ThesisLoadDamperConfig config;
      config.wire_length_m = believed;
      const MatrixXd loop = closed_loop<ThesisLoadLaw, 10, 3, 4>(
          ThesisLoadDamper(config), thesis_load_A(wire), thesis_load_B(Eigen::Matrix3d::Identity(), wire));
      // Axis by axis: (p, p', angle, rate, integral, filter).
      for (const int axis : {0, 1}) {
        const std::vector<int> states{axis, axis + 3, axis + 6, axis + 8, axis + 10, axis + 12};
        const auto length = [](double l) { return l == 2.0 ? std::string("2.0") : std::string("6.0"); };
        expect_poles(loop(states, states),
                     gain("NL cascade " + std::string(axis == 0 ? "x" : "y") + " L=" + length(wire) +
                          " damper L=" + length(believed) + " N=100.0"),
                     "cascade");
      }
    }
  }
}

TEST(ThesisMount, PutsTheToolPointAtHomeWhereTheThesisDoes) {
  // Pt_init of C.6.2, in N, printed to the millimetre; in W y and z are turned over.
  const plant::ThesisCrane crane(plant::ThesisMount::on_ship(), false, {});
  const Eigen::Vector3d printed(-2.395, -3.811, 3.255);
  EXPECT_LE((crane.at_neutral(home_m()) - printed).cwiseAbs().maxCoeff(), 1e-3);
}

}  // namespace
}  // namespace motionlab::thesis
