/// @file  The feedback gains of the thesis, from its weights: three sets of them, for they contradict.
#pragma once

#include <Eigen/Core>

namespace motionlab::controller {

/// Which weights the regulator is solved for.
enum class ThesisWeights {
  text,     ///< as printed in the text
  printed,  ///< those behind the printed gains, recovered by the return difference (inverse LQR)
  code,     ///< as in the author's scripts (App C)
};

// State feedback with pre-filter (FPF): u = N r − K x. With integral (IC): u = −Kz z − K x, z = ∫ (y − r).
// The thesis prints [−Ke Ko] for z = ∫ (r − y), but its first block has the sign of z = ∫ (y − r), as in its
// code; that is used here. (Eq 3.127, 4.28, 4.63, 4.86: the column of r must be [I; 0], not [0; 1].)

/// The pendulum in a plane; x = (x, x', theta, theta').
struct ThesisPendulumPrefilterGain {
  Eigen::RowVector4d K;
  double N;
};
struct ThesisPendulumIntegralGain {
  double Kz;
  Eigen::RowVector4d K;
};

/// The load below the arm; x = (tool point, its velocity, swing angles, rates).
struct ThesisLoadPrefilterGain {
  Eigen::Matrix<double, 3, 10> K;
  Eigen::Matrix3d N;
};
struct ThesisLoadIntegralGain {
  Eigen::Matrix3d Kz;
  Eigen::Matrix<double, 3, 10> K;
};

/// Linear model about hanging still (Eq 4.14, 4.15); wire 2 m and g = 9.81 m/s² in all designs.
[[nodiscard]] Eigen::Matrix4d thesis_pendulum_A();
[[nodiscard]] Eigen::Vector4d thesis_pendulum_B();
/// The same in space (Eq 4.43). @param R_WR  axes of the arm's coordinates in the axes of the swing angles
[[nodiscard]] Eigen::Matrix<double, 10, 10> thesis_load_A(double wire_length_m = 2.0);
[[nodiscard]] Eigen::Matrix<double, 10, 3> thesis_load_B(const Eigen::Matrix3d& R_WR,
                                                         double wire_length_m = 2.0);

/// Eq 4.24 and 4.25. The text's weights (4.23) do not give them; the code's do.
[[nodiscard]] ThesisPendulumPrefilterGain thesis_pendulum_prefilter(ThesisWeights weights);
/// Eq 4.36. The text's weights (4.34) do not give it; the code's do.
[[nodiscard]] ThesisPendulumIntegralGain thesis_pendulum_integral(ThesisWeights weights);
/// Eq 4.59 and 4.60. Neither the text's nor the code's weights (which are the same, 4.58) give the x and y
/// rows; the recovered ones do.
[[nodiscard]] ThesisLoadPrefilterGain thesis_load_prefilter(ThesisWeights weights);
/// Eq 4.69; likewise.
[[nodiscard]] ThesisLoadIntegralGain thesis_load_integral(ThesisWeights weights);
/// The motion system's (Sec 4.6.3). The text's weights do not give the printed Ke; the code's do, so
/// `printed` and `code` are the same. The printed Ko is missing in the thesis.
/// @param R_WR  robot base in the axes of the swing angles, platform at neutral
[[nodiscard]] ThesisLoadIntegralGain thesis_motion_integral(ThesisWeights weights,
                                                            const Eigen::Matrix3d& R_WR);

}  // namespace motionlab::controller
