#include "simulators/lab/thesis/table.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "gateway/controller/thesis_gains.hpp"
#include "gateway/controller/thesis_laws.hpp"
#include "gateway/estimator/thesis_ekf10.hpp"
#include "gateway/estimator/thesis_ekf35.hpp"
#include "gateway/estimator/thesis_filter4.hpp"
#include "gateway/math/control_properties.hpp"
#include "gateway/math/crane_arm.hpp"
#include "gateway/math/integrate.hpp"
#include "simulators/lab/thesis/metrics.hpp"
#include "simulators/lab/thesis/pushed_pendulum.hpp"
#include "simulators/lab/thesis/table_text.hpp"
#include "simulators/plant/thesis_crane.hpp"

namespace motionlab::thesis {
namespace {

using namespace controller;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::RowVectorXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector4d;
using Eigen::VectorXd;

constexpr double kDegree = std::numbers::pi / 180;

VectorXd list(std::initializer_list<double> values) {
  return Eigen::Map<const VectorXd>(values.begin(), static_cast<Eigen::Index>(values.size()));
}

void robot(TableText& table) {
  const auto tool = [](double d4, const Vector3d& q_deg) {
    return math::CraneArm({0.35, 1.16, 0.25, 0.83, d4 + 0.210 + 0.567}).position(q_deg * kDegree);
  };
  const auto tool_point = [&](std::string_view title, const Vector3d& q_deg, const Vector3d& printed) {
    table.item(title);
    table.printed(printed, 3);
    table.ours("forearm of Tab 3.1, 1.492 m", tool(1.492, q_deg), 4);
    table.ours("forearm of the code, 1.4922 m", tool(1.4922, q_deg), 4);
  };
  table.section("Robot (Sec 4.1)");
  tool_point("Tab 4.1  tool point at home, joints 0, 0, -90 deg [m]", {0, 0, -90}, {2.619, 0, 2.240});
  table.confirmed("the code's forearm is used, as Tab 3.1 rounds it");
  tool_point("Tab 4.2  tool point, joints -15, -20, -55 deg [m]", {-15, -20, -55}, {1.612, 0.432, 3.426});
  table.confirmed();

  table.item("Tab 4.3  load at home, 2 m of wire [m]");
  table.printed(Vector3d(2.619, 0, 0.240), 3);
  plant::ThesisCrane::State x = plant::ThesisCrane::State::Zero();
  x.head<3>() = home_m();
  table.ours("ours", plant::ThesisCrane({}, false, {}).p_WL(0, x), 4);
  table.confirmed();

  table.item("Tab 5.3  tool point at home, and B of Tab 5.4 [m]");
  table.printed(Vector3d(2.619, 0, 2.240), 3);
  table.ours("ours", home_m(), 4);
  table.confirmed();

  table.item("below Eq 3.24  which elbow is at home: joints 2 and 3 [deg]");
  table.printed(Vector2d(0, -90), 0);
  const auto q = math::CraneArm({0.35, 1.16, 0.25, 0.83, 2.2692}).inverse(home_m());
  table.ours("inverse kinematics, minus sign", q->tail<2>() / kDegree, 1);
  table.corrected("the minus sign is elbow-up and gives home; the text has the signs reversed");
}

void mount(TableText& table) {
  table.section("Robot on the platform (Sec 3.3, C.6)");
  table.item("C.6.1  rotation of H_b^r, rows one after the other");
  const Matrix3d printed = estimator::thesis_R_BR_as_printed();
  const Matrix3d ours = plant::ThesisMount::on_ship().X_BR.R;
  const auto rows = [](const Matrix3d& R) {
    const Matrix3d Rt = R.transpose();
    return VectorXd(Eigen::Map<const VectorXd>(Rt.data(), 9));
  };
  table.printed(rows(printed), 4);
  table.ours("nearest rotation", rows(ours), 5);
  table.corrected("four digits are no rotation: inverse and transpose differ by up to 7e-5");

  table.item("C.6.2  Pt_init, tool point at home in N [m]");
  table.printed(Vector3d(-2.395, 3.811, -3.255), 3);
  const plant::ThesisMount ship = plant::ThesisMount::on_ship();
  table.ours("ours", ship.X_BR * home_m(), 4);
  table.confirmed("the tool is above the platform at negative z, so N and B are z-down");
}

void inputs(TableText& table) {
  table.section("What is put in (Tab 4.4, 5.1, 5.2, 5.4)");
  const Eigen::Matrix<double, 6, 1> frequencies{0.1, 0.1, 0.1, 0.15, 0.1, 0.2};
  const plant::ShipCoordinates begin = plant::ThesisCrane(plant::ThesisMount::on_ship(), true, {}).ship(0);
  const Eigen::Array<double, 6, 1> sine =
      begin.eta_dot.array() / (2 * std::numbers::pi * frequencies.array());
  const Eigen::Array<double, 6, 1> cosine = begin.eta.array();
  VectorXd amplitude = (sine.square() + cosine.square()).sqrt();
  amplitude.tail<3>() /= kDegree;
  VectorXd phase(6);
  for (Eigen::Index i = 0; i < 6; ++i) phase[i] = std::atan2(cosine[i], sine[i]) / kDegree;
  table.item("Tab 4.4  amplitudes of x, y, z [m], phi, theta, psi [deg], from the ship at t = 0");
  table.printed(list({0.1, 0.2, 0.2, 5, 5, 5}), 1);
  table.ours("ours", amplitude, 3);
  table.confirmed();
  table.item("Tab 4.4  phases [deg]");
  table.printed(list({0, 45, 90, 90, 0, 120}), 0);
  table.ours("ours", phase, 2);
  table.confirmed(
      "at 0.1, 0.1, 0.1, 0.15, 0.1, 0.2 Hz; the table lists theta before phi and heads all with m");
  table.item("Tab 5.2  swing angles at the start of an offset scenario [deg] (Tab 5.1: zero)");
  table.printed(Vector2d(15, 20), 1);
  Request request;
  request.scenario = "thesis-load-1";
  request.estimator = "ideal";
  request.seconds = 0.001;
  Vector2d start;
  simulate(choose(request), [&start](const Sample& s) { start = s.state.segment<2>(6) / kDegree; });
  table.ours("ours", start, 3);
  table.confirmed();
  table.item("Tab 5.4  amplitudes of the sinus [m], at 0.07, 0.09, 0.15 Hz");
  table.printed(Vector3d(0.5, 0.3, 0.25), 2);
  const Reference sinus(ReferenceKind::sinus);
  const auto crest = [&sinus](double frequency_hz) { return sinus.at(0, 0.25 / frequency_hz); };
  table.ours("ours, a quarter of a period on", Vector3d(crest(0.07).x(), crest(0.09).y(), crest(0.15).z()),
             3);
  table.confirmed();
}

/// Weights that make a gain optimal, rounded to four digits, beside those of the text.
void weights(TableText& table, std::string_view name, const MatrixXd& A, const VectorXd& b,
             const VectorXd& printed_weights, std::initializer_list<double> printed_gain) {
  const RowVectorXd k = list(printed_gain).transpose();
  table.printed(printed_weights, 0);
  table.ours(name, math::recover_weights(A, b, k).q, 0);
}

MatrixXd with_integral(const MatrixXd& A) {
  MatrixXd Ai = MatrixXd::Zero(A.rows() + 1, A.cols() + 1);
  Ai(0, 1) = 1;
  Ai.bottomRightCorner(A.rows(), A.cols()) = A;
  return Ai;
}

VectorXd with_zero(const VectorXd& b) {
  VectorXd bi(b.size() + 1);
  bi << 0, b;
  return bi;
}

VectorXd joined(double first, const RowVectorXd& rest) {
  VectorXd all(rest.size() + 1);
  all << first, rest.transpose();
  return all;
}

void pendulum_gains(TableText& table) {
  table.section("Gains of the pendulum in a plane (Sec 4.4.4)");
  const auto text = thesis_pendulum_prefilter(ThesisWeights::text);
  const auto code = thesis_pendulum_prefilter(ThesisWeights::code);
  table.item("Eq 4.24  K of the pre-filter: x, x', theta, theta'");
  table.printed(list({10.00, 18.10, -101.88, 4.78}), 2);
  table.ours("weights of the text", text.K.transpose(), 2);
  table.ours("weights of the code", code.K.transpose(), 2);
  table.corrected("the weights of Eq 4.23 do not give it, those of C.4.2 do (-101.875 was rounded up)");
  table.item("Eq 4.23  its weights");
  const MatrixXd A = thesis_pendulum_A();
  const VectorXd b = thesis_pendulum_B();
  weights(table, "recovered from the printed K", A, b, list({1e3, 1e3, 1e5, 1e2}),
          {10.00, 18.10, -101.88, 4.78});
  table.corrected("100, 100, 1e4, 100 as in C.4.2");
  table.item("Eq 4.25  N of the pre-filter");
  table.printed(list({10}), 0);
  table.ours("weights of the text", list({text.N}), 2);
  table.ours("weights of the code", list({code.N}), 2);
  table.corrected("it follows K: from the weights of C.4.2");

  const auto integral_text = thesis_pendulum_integral(ThesisWeights::text);
  const auto integral_code = thesis_pendulum_integral(ThesisWeights::code);
  table.item("Eq 4.36  [-Ke Ko] of the integral: z, x, x', theta, theta'");
  table.printed(list({31.62, 72.38, 67.02, -249.17, 88.49}), 2);
  table.ours("weights of the text", joined(integral_text.Kz, integral_text.K), 2);
  table.ours("weights of the code", joined(integral_code.Kz, integral_code.K), 2);
  table.corrected(
      "the weights of Eq 4.34 do not give it, those of C.4.2 do; and with z = int(r - y) of Eq 4.28 the "
      "first "
      "entry is -31.62, the printed plus belongs to z = int(y - r)");
  table.item("Eq 4.34  its weights");
  weights(table, "recovered from the printed K", with_integral(A), with_zero(b),
          list({1e3, 1e3, 1e3, 1e5, 1e2}), {31.62, 72.38, 67.02, -249.17, 88.49});
  table.corrected("1e2 on x' as in C.4.2");
}

/// The states of one horizontal axis of the load, or of the vertical one.
struct Axis {
  std::string_view name;
  std::vector<int> states;
  int input;
};

const std::array<Axis, 3>& axes() {
  static const std::array<Axis, 3> all{{{"x", {0, 3, 6, 8}, 0}, {"y", {1, 4, 7, 9}, 1}, {"z", {2, 5}, 2}}};
  return all;
}

VectorXd part(const MatrixXd& K, const Axis& axis) {
  const RowVectorXd row = K.row(axis.input);
  return row(axis.states).transpose();
}

void load_prefilter_gains(TableText& table) {
  const auto text = thesis_load_prefilter(ThesisWeights::text);
  const auto recovered = thesis_load_prefilter(ThesisWeights::printed);
  const MatrixXd A = thesis_load_A(), B = thesis_load_B(Matrix3d::Identity());
  const std::array<std::vector<double>, 3> printed{
      {{31.62, 41.07, 236.32, 25.55}, {10.0, 34.28, -76.10, -4.82}, {31.62, 12.78}}};
  const std::array<double, 4> weights_of_text{1e3, 1e2, 1e4, 1e3};
  table.section("Gains of the suspended load (Sec 4.5.4)");
  for (std::size_t i = 0; i < 3; ++i) {
    const Axis& axis = axes()[i];
    const auto n = static_cast<Eigen::Index>(axis.states.size());
    const VectorXd k = Eigen::Map<const VectorXd>(printed[i].data(), n);
    table.item("Eq 4.59  row " + std::string(axis.name) + " of K, pre-filter: position, velocity" +
               (n == 4 ? ", angle, rate (the rest is zero)" : " (the rest is zero)"));
    table.printed(k, 2);
    table.ours("weights of the text, and code", part(text.K, axis), 2);
    table.ours("recovered weights", part(recovered.K, axis), 2);
    const VectorXd told = Eigen::Map<const VectorXd>(weights_of_text.data(), n);
    const VectorXd b = B.col(axis.input);
    const auto found = math::recover_weights(A(axis.states, axis.states), b(axis.states), k.transpose());
    table.numbers("its weights in Eq 4.58", told, 0);
    table.numbers("weights behind the printed row", found.q, 0);
    if (n == 2) {
      table.confirmed();
    } else {
      table.corrected("Eq 4.58 and C.5.2 agree and make x and y alike; the row was made with other weights");
    }
  }
  table.item("Eq 4.60  diagonal of N");
  table.printed(Vector3d(31.62, 10.0, 31.62), 2);
  table.ours("weights of the text, and code", text.N.diagonal(), 2);
  table.ours("recovered weights", recovered.N.diagonal(), 2);
  table.corrected("it follows K");
}

void load_integral_gains(TableText& table) {
  const auto text = thesis_load_integral(ThesisWeights::text);
  const auto recovered = thesis_load_integral(ThesisWeights::printed);
  table.item("Eq 4.69  diagonal of -Ke");
  table.printed(Vector3d(31.62, 31.62, 31.62), 2);
  table.ours("weights of the text, and code", text.Kz.diagonal(), 2);
  table.confirmed(
      "with z = int(y - r), as in C.5.2; Eq 4.63 has the other sign and an r column [0; 1] for [I; 0]");
  const MatrixXd A = thesis_load_A(), B = thesis_load_B(Matrix3d::Identity());
  const std::array<std::vector<double>, 3> printed{
      {{69.85, 61.32, 241.17, -13.45}, {53.95, 44.43, -71.00, 13.27}, {43.17, 13.65}}};
  const std::array<double, 5> weights_of_text{1e3, 1e3, 1e2, 1e4, 1e3};
  for (std::size_t i = 0; i < 3; ++i) {
    const Axis& axis = axes()[i];
    const auto n = static_cast<Eigen::Index>(axis.states.size());
    const VectorXd k = Eigen::Map<const VectorXd>(printed[i].data(), n);
    table.item("Eq 4.69  row " + std::string(axis.name) + " of Ko, integral: position, velocity" +
               (n == 4 ? ", angle, rate" : ""));
    table.printed(k, 2);
    table.ours("weights of the text, and code", part(text.K, axis), 2);
    table.ours("recovered weights", part(recovered.K, axis), 2);
    const VectorXd b = B.col(axis.input);
    const auto found =
        math::recover_weights(with_integral(A(axis.states, axis.states)), with_zero(b(axis.states)),
                              joined(31.62, k.transpose()).transpose());
    table.numbers("its weights in Eq 4.68", Eigen::Map<const VectorXd>(weights_of_text.data(), n + 1), 0);
    table.numbers("weights behind the printed row", found.q, 0);
    if (n == 2) {
      table.confirmed();
    } else if (i == 0) {
      table.corrected("as in Eq 4.59, other weights than Eq 4.68 and C.5.2");
    } else {
      table.corrected("as in Eq 4.59, other weights than Eq 4.68 and C.5.2; -71.006 is printed -71.00");
    }
  }
}

void motion_gains(TableText& table) {
  const Matrix3d raw = estimator::thesis_R_BR_as_printed();
  const auto text = thesis_motion_integral(ThesisWeights::text, raw);
  const auto code = thesis_motion_integral(ThesisWeights::code, raw);
  const estimator::ThesisEkf35Config belief;
  const auto world = thesis_motion_integral(ThesisWeights::code, belief.R_WN * belief.R_BR);
  table.section("Gains of the motion system (Sec 4.6.3)");
  table.item("Sec 4.6.3  diagonal of -Ke");
  table.printed(Vector3d(100, 100, 100), 2);
  table.ours("weights of the text", text.Kz.diagonal(), 2);
  table.ours("weights of the code", code.Kz.diagonal(), 2);
  table.corrected("Eq 4.91 weighs z with 1e3; 1e4 of C.6.2 gives it");
  table.item("Sec 4.6.3  Ko: the thesis announces it and does not print it");
  for (int row = 0; row < 3; ++row) {
    const std::string axis(1, "xyz"[row]);
    table.numbers("code weights, {n}, row " + axis, code.K.row(row).transpose(), 3);
  }
  for (int row = 0; row < 3; ++row) {
    const std::string axis(1, "xyz"[row]);
    table.numbers("code weights, world, row " + axis, world.K.row(row).transpose(), 3);
  }
  table.corrected("in world axes y is turned over, so the columns of beta and its rate change sign");
}

/// d/dt by (states, memory) of a linear axis under a law, by differences.
template <class Law, int N, int M, int Memories>
MatrixXd loop_of(const Law& law, const MatrixXd& A, const MatrixXd& B) {
  const auto rate = [&](double, const Eigen::Matrix<double, N + Memories, 1>& both) {
    const typename Law::State x = both.template head<N>();
    const typename Law::Memory memory = both.template tail<Memories>();
    const typename Law::Input r = Law::Input::Zero();
    Eigen::Matrix<double, N + Memories, 1> d;
    d << A * x + B * law.command(x, memory, r), law.memory_rate(x, memory, r);
    return d;
  };
  return math::difference_jacobian(rate, 0.0, Eigen::Matrix<double, N + Memories, 1>::Zero().eval());
}

double slowest_pole(const MatrixXd& A) {
  return Eigen::EigenSolver<MatrixXd>(A, false).eigenvalues().real().maxCoeff();
}

void dampers(TableText& table) {
  table.section("Virtual dampers (Sec 4.4.5, 4.5.5)");
  table.item(
      "Eq 4.39, 4.40  damper of the pendulum, d = 5, with PD 0.2, 0.85: largest real part of a pole [1/s]");
  const auto damped = [](double d) {
    ThesisPendulumDamperConfig config;
    config.damping_per_s = d;
    const MatrixXd loop = loop_of<ThesisPendulumLaw, 4, 1, 1>(ThesisPendulumDamper(config),
                                                              thesis_pendulum_A(), thesis_pendulum_B());
    return slowest_pole(loop.topLeftCorner<4, 4>());
  };
  table.numbers("sign as printed", list({damped(-5)}), 3);
  table.numbers("ours, +L d theta' / cos theta", list({damped(5)}), 3);
  table.corrected("with the printed sign the loop is unstable");
  table.item(
      "Tab 4.5, Eq 4.73, 4.74  cascade with dampers 7 and 5: largest real part of a pole, x and y [1/s]");
  const ThesisLoadDamperConfig tab;
  table.printed(list({4.786, 3.324, 0.577, 0.103, 1.002, 0.408, 0.788, 0.072}), 3);
  table.ours("ours",
             list({tab.speed_gain[0], tab.speed_derivative_gain[0], tab.position_gain[0],
                   tab.position_integral_gain[0], tab.speed_gain[1], tab.speed_derivative_gain[1],
                   tab.position_gain[1], tab.position_integral_gain[1]}),
             3);
  table.line("largest real part of a pole, x and y [1/s]:");
  const auto cascade = [](double wire, double believed) {
    ThesisLoadDamperConfig config;
    config.wire_length_m = believed;
    const MatrixXd loop = loop_of<ThesisLoadLaw, 10, 3, 4>(ThesisLoadDamper(config), thesis_load_A(wire),
                                                           thesis_load_B(Matrix3d::Identity(), wire));
    const std::vector<int> x{0, 3, 6, 8, 10, 12}, y{1, 4, 7, 9, 11, 13};
    return Vector2d(slowest_pole(loop(x, x)), slowest_pole(loop(y, y)));
  };
  table.numbers("on 2 m of wire", cascade(2, 2), 3);
  table.numbers("on 6 m, damper for 2 m", cascade(6, 2), 3);
  table.numbers("on 6 m, damper for 6 m", cascade(6, 6), 3);
  table.confirmed("on 6 m \"on the verge of instability\"; height is not controlled");
}

void estimators(TableText& table) {
  using namespace estimator;
  table.section("Estimators (Sec 4.4.3, 4.5.2, 4.6.2)");
  table.item(
      "Fig 4.20, 4.21  error of the angle on 2 m and 4 m of wire (the model has 2 m), 10-20 s [deg rms]");
  const auto pushed = [](const auto& filter) {
    return Vector2d(push_pendulum(filter, 2.0, 1.0).late_angle_rms_deg,
                    push_pendulum(filter, 4.0, 1.0).late_angle_rms_deg);
  };
  table.numbers("extended filter", pushed(ThesisEkf4()), 3);
  table.numbers("linear, same numbers a step", pushed(ThesisKf4()), 3);
  table.numbers("linear, numbers as densities",
                pushed(ThesisKf4({}, Vector4d::Zero(), ThesisKf4Form::continuous)), 3);
  table.corrected(
      "the linear filter fails for its tuning: a continuous filter reads Q and R as densities, a Q/R 1e6 "
      "smaller");
  table.item("Eq 4.49  deviation of the measured angles, 10 states [rad]");
  table.printed(list({0.01}), 2);
  table.ours("ours", list({ThesisEkf10Config{}.measurement_deviation_angle_rad}), 2);
  table.corrected(
      "C.5.1 sets rows 4:5 and means 7:8, so that its angles weigh 1 rad, and derives h by u (zero)");
  table.item("Tab 4.6  initial deviation of every state, 35 states");
  const ThesisEkf35Config ekf35;
  table.printed(list({0.001}), 3);
  table.ours("ours", list({ekf35.initial_deviation}), 3);
  table.confirmed();
  table.item("Tab 4.6  process deviations: eta, v, v', P, P', P'', L, L', phi, phi', phi''");
  const double other = ekf35.process_deviation;
  table.printed(list({0.001, 0.05, 0.05, 0.05, 0.05, 0.05, 0.001, 0.05, 0.05, 0.1, 0.1}), 3);
  table.ours("ours, as in C.6.2",
             list({other, other, ekf35.process_deviation_platform_acceleration, other, other,
                   ekf35.process_deviation_arm_acceleration, other, ekf35.process_deviation_wire_speed, other,
                   ekf35.process_deviation_swing_rate, ekf35.process_deviation_swing_acceleration}),
             3);
  table.corrected("C.6.2 made the figures; where it sets Q(32:33) twice, the second means 34:35");
  table.item("Tab 4.6  measurement deviations: eta, v, P, P', L, phi, phi'");
  table.printed(list({0.01, 0.01, 0.001, 0.001, 0.001, 0.1, 0.1}), 3);
  table.ours("ours",
             list({ekf35.measurement_deviation_platform, ekf35.measurement_deviation_platform,
                   ekf35.measurement_deviation_arm, ekf35.measurement_deviation_arm,
                   ekf35.measurement_deviation_wire, ekf35.measurement_deviation_swing,
                   ekf35.measurement_deviation_swing}),
             3);
  table.confirmed(
      "where C.6.2 sets R(31:32), it means 32:33; the other rows are not measured and mean nothing");
  table.item("Eq 4.77  of 35 states, so many are seen by the 23 measurements");
  table.printed(list({35}), 0);
  const auto rank = [](ThesisArmAcceleration source) {
    ThesisEkf35Config config;
    config.arm_acceleration = source;
    math::KalmanState<ThesisEkf35::kStates> start;
    for (int i = 0; i < ThesisEkf35::kStates; ++i) start.x[i] = 0.02 * (i % 7) - 0.05;
    start.x.segment<3>(ThesisEkf35::kP) = home_m();
    start.x[ThesisEkf35::kL] = 2.1;
    const ThesisEkf35 filter(config, start);
    return VectorXd::Constant(1, math::observability_rank(filter.rate_jacobian({0.4, -0.2, 0.1, 2.15}),
                                                          ThesisEkf35::measurement_matrix()));
  };
  table.ours("arm's acceleration from u (C.6.1)", rank(ThesisArmAcceleration::input), 0);
  table.ours("arm's acceleration a state", rank(ThesisArmAcceleration::state), 0);
  table.corrected("x(25:27) is overwritten by u, and the swing accelerations x(34:35) enter nothing");
}

void equations(TableText& table) {
  table.section("Equations (Ch 3)");
  for (const std::string_view text :
       {"Eq 3.2-3.31   robot kinematics and Jacobians: confirmed (Eq 3.10 J13 lacks a parenthesis)",
        "Eq 3.45       pendulum in a plane: confirmed",
        "Eq 3.51       kinetic energy: corrected: several terms lack a dot or a square; 3.56, 3.57 do not "
        "suffer",
        "Eq 3.56, 3.57 pendulum in space: confirmed; C.2.1 and C.6.1 have +2 L' b' cos a for -2 L' b' cos a",
        "Eq 3.60       rotation order: corrected: Rz(psi) Ry(theta) Rx(phi), as in the code and as Eq 3.68 "
        "needs",
        "Eq 3.68       Euler rates from body rates: confirmed, with that order",
        "Eq 3.74, 3.75 platform acceleration: corrected: v' = J^-1 (eta'' - J' v), J' = dJ/dt",
        "Eq 3.81, 3.82 tool in world: corrected: turned by R_n^g; without it heave enters the swing upside "
        "down",
        "Eq 3.89, 3.90 angles from the camera: corrected: hold for a wire vector turned into the world first",
        "Eq 4.28, 4.63, 4.86  integral: corrected: the column of r is [I; 0]",
        "Eq 5.2        wire: corrected: 2 + 0.75 sin(2 pi 0.05 t), the t was lost", "sway"}) {
    table.line(text);
  }
}

void result(TableText& table, const Request& request) {
  const Run run = choose(request);
  const Metrics m = measure(run);
  std::string name = std::string(run.scenario->name) + " " + std::string(to_string(run.controller));
  name.resize(std::max<std::size_t>(name.size(), 29), ' ');
  table.line(name + fixed(m.swing_axis_rms_deg[0], 2, 8) + fixed(m.swing_axis_rms_deg[1], 2, 8) +
             fixed(m.swing_axis_max_deg[0], 1, 8) + fixed(m.swing_axis_max_deg[1], 1, 8) +
             fixed(m.tool_rms_m, 3, 9) + fixed(m.load_rms_m, 3, 9) +
             (m.settle_censored ? "        -" : fixed(m.settle_1deg_s, 2, 9)) +
             fixed(*std::max_element(m.joint_speed_max_degps.begin(), m.joint_speed_max_degps.end()), 0, 9) +
             (m.reach_ok ? "" : "  beyond reach"));
}

void results(TableText& table) {
  table.section("Scenarios (Ch 5; the thesis prints curves only)");
  table.line(
      "state known, weights of the code, world frame; settle: longest time after an event to within 1 deg "
      "(-: not)");
  table.line(
      "                               swing rms [deg]  swing max [deg] tool rms load rms   settle   joints");
  table.line(
      "                               alpha    beta   alpha    beta      [m]      [m]      [s]  [deg/s]");
  for (const Scenario& scenario : scenarios()) {
    if (scenario.system == System::pendulum) continue;
    Request request;
    request.scenario = scenario.name;
    request.estimator = "ideal";
    if (scenario.system == System::motion) {
      result(table, request);
      continue;
    }
    for (const char* controller : {"prefilter", "integral", "damper"}) {
      request.controller = controller;
      result(table, request);
    }
  }
  table.item("Sec 5.3.5, 6.3, 7  \"reduces the swing\" in waves");
  table.corrected(
      "compare thesis-motion-4 and -5: what goes is the free swing of a start without friction; the load "
      "still "
      "goes where the ship goes");
}

}  // namespace

std::string comparison_table() {
  TableText table;
  robot(table);
  mount(table);
  inputs(table);
  pendulum_gains(table);
  load_prefilter_gains(table);
  load_integral_gains(table);
  motion_gains(table);
  dampers(table);
  estimators(table);
  equations(table);
  results(table);
  return table.text();
}

}  // namespace motionlab::thesis
