// What the mathematics of one control step costs, beside other people's: serial chains against Orocos KDL,
// extended Kalman filters against Orocos BFL, on the same models and to the same results.
//   bench_math           fails when results differ, ours allocates, or ours is the slower
//   bench_math --short   few calls, and no word on speed: a test for any machine
#include <kdl/chainfksolverpos_recursive.hpp>
#include <kdl/chainiksolverpos_lma.hpp>
#include <kdl/chainjnttojacsolver.hpp>

#include <cmath>
#include <cstring>
#include <optional>

#include "drivers/core/random.hpp"
#include "gateway/controller/guard.hpp"
#include "gateway/controller/load_keeper.hpp"
#include "gateway/estimator/thesis_ekf10.hpp"
#include "gateway/estimator/thesis_ekf35.hpp"
#include "gateway/math/pendulum.hpp"
#include "tests/bench/bfl_filter.hpp"
#include "tests/bench/recording.hpp"
#include "tests/bench/table.hpp"
#include "tests/unit/math/kdl_arm.hpp"

namespace motionlab {
namespace {

using test::Table;
using test::Vector6;

/// Beyond this, two libraries do not compute the same.
constexpr double kSame = 1e-9;

/// Says once what differs.
bool same(const char* what, double difference, double tolerance = kSame) {
  if (difference <= tolerance) return true;
  std::printf("%s: ours and theirs differ by %.3g\n", what, difference);
  return false;
}

/// Keeps the compiler from leaving out what nobody reads.
double sink = 0;

// ---------------------------------------------------------------- kinematics, thesis Tab A.4

bool kinematics(Table& table, std::size_t calls) {
  const auto arm = test::six_axis_arm(test::kTool);
  const KDL::Chain chain = test::kdl_six_axis_arm(test::kTool);
  KDL::ChainFkSolverPos_recursive kdl_forward(chain);
  KDL::ChainJntToJacSolver kdl_jacobian(chain);
  KDL::ChainIkSolverPos_LMA kdl_inverse(chain, kSame);
  math::InverseOptions options;
  options.position_tolerance_m = options.rotation_tolerance_rad = kSame / 2;

  struct Pose {
    Vector6 q, start;
    KDL::JntArray kdl_q, kdl_start;
  };
  Random random(1);
  std::vector<Pose> poses(200);
  for (Pose& pose : poses) {
    for (int i = 0; i < 6; ++i) {
      pose.q[i] = test::six_axis_home()[i] + random.uniform(-0.8, 0.8);
      pose.start[i] = random.uniform(-0.1, 0.1);
    }
    pose.q[4] = random.uniform(0.4, 1.2);  // clear of the wrist's singularity
    pose.start += pose.q;
    pose.kdl_q = test::table_angles(pose.q);
    pose.kdl_start = test::table_angles(pose.start);
  }
  const auto pose = [&](std::size_t i) -> const Pose& { return poses[i % poses.size()]; };

  KDL::Frame X;
  KDL::Jacobian J(6);
  KDL::JntArray found(6);
  table.compare(
      "6 axes, forward (KDL)", 100 * calls, [&](std::size_t i) { sink += arm.tool(pose(i).q).p.x(); },
      [&](std::size_t i) {
        kdl_forward.JntToCart(pose(i).kdl_q, X);
        sink += X.p.x();
      });
  table.compare(
      "6 axes, Jacobian (KDL)", 100 * calls, [&](std::size_t i) { sink += arm.jacobian(pose(i).q)(0, 0); },
      [&](std::size_t i) {
        kdl_jacobian.JntToJac(pose(i).kdl_q, J);
        sink += J(0, 0);
      });
  table.compare(
      "6 axes, forward and inverse (KDL)", calls,
      [&](std::size_t i) { sink += arm.inverse(arm.tool(pose(i).q), pose(i).start, options).q[0]; },
      [&](std::size_t i) {
        kdl_forward.JntToCart(pose(i).kdl_q, X);
        kdl_inverse.CartToJnt(pose(i).kdl_start, X, found);
        sink += found(0);
      });
  const auto crane = test::crane_arm();
  const auto limits = test::strokes();
  table.alone("3 axes, forward, both inverses", 100 * calls, [&](std::size_t i) {
    const auto all = crane.inverse(crane.position(pose(i).q.head<3>()), limits);
    sink += all.elbow_up ? all.elbow_up->q[1] : 0;
  });

  // Theirs stops some 1e-7 off in turning, which it weighs by 0.01.
  double place = 0, reached = 0, theirs_reached = 0;
  for (const Pose& p : poses) {
    const auto goal = arm.tool(p.q);
    kdl_forward.JntToCart(p.kdl_q, X);
    place = std::max(place, (goal.p - test::position(X)).norm());
    reached = std::max(reached, (arm.tool(arm.inverse(goal, p.start, options).q).p - goal.p).norm());
    if (kdl_inverse.CartToJnt(p.kdl_start, X, found) < 0) continue;
    kdl_forward.JntToCart(found, X);
    theirs_reached = std::max(theirs_reached, (goal.p - test::position(X)).norm());
  }
  bool all_same = same("forward kinematics", place);
  all_same &= same("goal and our inverse", reached);
  return same("goal and KDL's inverse", theirs_reached, 1e-6) && all_same;
}

// ---------------------------------------------------------------- filters

using Vec = Eigen::VectorXd;

double square(double v) {
  return v * v;
}

/// 10 states (thesis Sec 4.5.2). BFL evaluates the model at its own state.
bool filter_of_10(Table& table, std::size_t calls) {
  using Ekf = estimator::ThesisEkf10;
  const estimator::ThesisEkf10Config config;
  const double dt = config.period_s;
  const Eigen::Vector3d p_RT(1.9, 0.1, 1.7);

  Vec Q(10), R(5), x0 = Vec::Zero(10);
  Q << Vec::Constant(3, square(config.process_deviation_position_m)),
      Vec::Constant(3, square(config.process_deviation_speed_mps)),
      Vec::Constant(2, square(config.process_deviation_angle_rad)),
      Vec::Constant(2, square(config.process_deviation_rate_radps));
  R << Vec::Constant(3, square(config.measurement_deviation_position_m)),
      Vec::Constant(2, square(config.measurement_deviation_angle_rad));
  x0.head<3>() = p_RT;

  Random random(2);
  std::vector<Ekf::Measurement> z(calls);
  std::vector<Ekf::Input> u(calls);
  std::vector<test::bfl::ColumnVector> their_z, their_u;
  for (std::size_t i = 0; i < calls; ++i) {
    const double t = dt * static_cast<double>(i);
    u[i] = {0.5 * std::sin(t), 0.4 * std::cos(1.3 * t), 0.3 * std::sin(0.7 * t)};
    z[i] << p_RT, 0.2 * std::sin(2.2 * t), 0.1 * std::cos(2.2 * t);
    for (int k = 0; k < 5; ++k) z[i][k] += 1e-3 * random.normal();
    their_z.push_back(test::bfl::column(z[i]));
    their_u.push_back(test::bfl::column(u[i]));
  }

  // The swing's part of the model; everything else is integration.
  const auto swing = [](const test::bfl::ColumnVector& x, int first) {
    return Eigen::Vector2d(x(static_cast<unsigned>(first)), x(static_cast<unsigned>(first + 1)));
  };
  const auto input = [](const test::bfl::ColumnVector& a) { return Eigen::Vector3d(a(1), a(2), a(3)); };
  test::bfl::Transition transition(
      Q,
      [&](const test::bfl::ColumnVector& x, const test::bfl::ColumnVector& a) {
        test::bfl::ColumnVector next(x);
        const auto swing_dd = math::swing_acceleration<double>(
            swing(x, 7), swing(x, 9), input(a), config.wire_length_m, 0.0, config.gravity_mps2);
        for (unsigned i = 1; i <= 3; ++i) {
          next(i) += dt * x(i + 3);
          next(i + 3) += dt * a(i);
        }
        for (unsigned i = 7; i <= 8; ++i) {
          next(i) += dt * x(i + 2);
          next(i + 2) += dt * swing_dd[i - 7];
        }
        return next;
      },
      [&](const test::bfl::ColumnVector& x, const test::bfl::ColumnVector& a) {
        test::bfl::Matrix F(10, 10);
        F = 0.0;
        for (unsigned i = 1; i <= 10; ++i) F(i, i) = 1;
        for (unsigned i = 1; i <= 3; ++i) F(i, i + 3) = dt;
        for (unsigned i = 7; i <= 8; ++i) F(i, i + 2) = dt;
        const auto D = math::swing_jacobian(swing(x, 7), swing(x, 9), input(a), config.wire_length_m, 0.0,
                                            config.gravity_mps2);
        for (unsigned i = 0; i < 2; ++i) {
          for (unsigned j = 0; j < 4; ++j) F(9 + i, 7 + j) += dt * D(i, j);
        }
        return F;
      });

  std::optional<Ekf> ours;
  std::optional<test::BflFilter> theirs;
  const auto step_ours = [&](std::size_t i) {
    if (i == 0) ours.emplace(config, p_RT);
    ours->update(z[i]);
    ours->predict(u[i]);
  };
  const auto step_theirs = [&](std::size_t i) {
    if (i == 0) {
      theirs.emplace(x0, Vec::Constant(10, config.initial_variance), Ekf::measurement_matrix(), R,
                     transition);
    }
    theirs->step(their_z[i], their_u[i]);
  };
  table.compare("EKF of 10 states, 5 seen (BFL)", calls, step_ours, step_theirs);
  double difference = 0;
  for (std::size_t i = 0; i < calls; ++i) {
    step_ours(i);
    step_theirs(i);
    if (i % 20 == 0 || i + 1 == calls) difference = std::max(difference, theirs->difference(ours->state()));
  }
  return same("EKF of 10 states", difference);
}

/// 35 states (thesis Sec 4.6.2). BFL is handed f(x) and F of every step, made beforehand: it pays for the
/// filter alone, ours for the model, too.
bool filter_of_35(Table& table, std::size_t calls) {
  using Ekf = estimator::ThesisEkf35;
  const estimator::ThesisEkf35Config config;
  const Eigen::Vector3d p_RT(1.9, 0.1, 1.7);
  constexpr double kWire = 2.0;

  Vec Q = Vec::Constant(35, square(config.process_deviation));
  Q.segment<6>(Ekf::kVdot).setConstant(square(config.process_deviation_platform_acceleration));
  Q.segment<3>(Ekf::kPddot).setConstant(square(config.process_deviation_arm_acceleration));
  Q[Ekf::kLdot] = square(config.process_deviation_wire_speed);
  Q.segment<2>(Ekf::kPhiDot).setConstant(square(config.process_deviation_swing_rate));
  Q.segment<2>(Ekf::kPhiDdot).setConstant(square(config.process_deviation_swing_acceleration));

  std::optional<Ekf> ours;
  ours.emplace(config, p_RT, kWire);
  const Vec x0 = ours->state().x, R = ours->measurement_variances();

  Random random(3);
  std::vector<Ekf::Measurement> z(calls);
  std::vector<Ekf::Input> u(calls);
  std::vector<test::bfl::ColumnVector> their_z, their_u, f;
  std::vector<test::bfl::Matrix> F;
  for (std::size_t i = 0; i < calls; ++i) {
    const double t = config.period_s * static_cast<double>(i);
    u[i] = {0.5 * std::sin(t), 0.4 * std::cos(1.3 * t), 0.3 * std::sin(0.7 * t), kWire + 0.1 * std::sin(t)};
    z[i].setZero();
    for (int k = 0; k < 6; ++k) z[i][k] = 0.08 * std::sin(0.7 * t + k);
    z[i].segment<3>(12) = p_RT;
    z[i][18] = kWire;
    z[i].segment<2>(19) << 0.2 * std::sin(2.2 * t), 0.1 * std::cos(2.2 * t);
    for (int k = 0; k < Ekf::kMeasured; ++k) z[i][k] += 1e-3 * random.normal();
    their_z.push_back(test::bfl::column(z[i]));
    their_u.push_back(test::bfl::column(u[i]));
    ours->update(z[i]);
    const Ekf::Matrix derivative = Ekf::Matrix::Identity() + config.period_s * ours->rate_jacobian(u[i]);
    F.push_back(test::bfl::matrix(derivative));
    ours->predict(u[i]);
    f.push_back(test::bfl::column(ours->state().x));
  }

  std::size_t now = 0;
  test::bfl::Transition transition(
      Q, [&](const auto&, const auto&) { return f[now]; }, [&](const auto&, const auto&) { return F[now]; });
  std::optional<test::BflFilter> theirs;
  const auto step_ours = [&](std::size_t i) {
    if (i == 0) ours.emplace(config, p_RT, kWire);
    ours->update(z[i]);
    ours->predict(u[i]);
  };
  const auto step_theirs = [&](std::size_t i) {
    if (i == 0) {
      theirs.emplace(x0, Vec::Constant(35, square(config.initial_deviation)), Ekf::measurement_matrix(), R,
                     transition);
    }
    now = i;
    theirs->step(their_z[i], their_u[i]);
  };
  table.compare("EKF of 35 states, 23 seen (BFL)", calls, step_ours, step_theirs);
  double difference = 0;
  for (std::size_t i = 0; i < calls; ++i) {
    step_ours(i);
    step_theirs(i);
    if (i % 20 == 0 || i + 1 == calls) difference = std::max(difference, theirs->difference(ours->state()));
  }
  return same("EKF of 35 states", difference);
}

// ---------------------------------------------------------------- our control step

void control_step(Table& table, std::size_t calls) {
  const test::Recording recording = test::record(calls);
  const auto& [belief, heard] = recording;
  const estimator::LabEstimator new_estimator(belief);  // made at start-up, where allocation is allowed
  estimator::LabEstimator estimator = new_estimator;
  const auto estimate = [&](std::size_t i) {
    if (i == 0) estimator = new_estimator;
    return estimator.step(recording.heard[i]);
  };
  table.alone("estimator, 40 states, a period", calls,
              [&](std::size_t i) { sink += estimate(i).p_world_tool_m[0]; });

  controller::LoadKeeperConfig config;
  config.arm = belief.calibration.arm;
  config.X_BR = belief.calibration.X_BR;
  std::vector<controller::KeeperInputs> told(calls);
  for (std::size_t i = 0; i < calls; ++i) {
    auto& in = told[i];
    in.t = in.t_send = heard[i].t;
    in.estimate = estimate(i);
    if (heard[i].arm) in.arm = *heard[i].arm;
    in.reference.p_WL = {0.847625, -0.407825, 3.919269};
    in.engaged = in.estimate.valid;
  }
  const controller::LoadKeeper new_keeper(config);
  controller::LoadKeeper keeper = new_keeper;
  const auto keep = [&](std::size_t i) {
    if (i == 0) keeper = new_keeper;
    return keeper.step(told[i]);
  };
  table.alone("controller, a period", calls, [&](std::size_t i) {
    const auto wish = keep(i);
    sink += wish ? wish->qd_radps[0] : 0;
  });

  controller::GuardLimits limits;
  limits.q_min_rad.fill(-2.5);
  limits.q_max_rad.fill(2.5);
  limits.qd_max_radps.fill(0.5);
  limits.qdd_max_radps2.fill(3);
  limits.wire_min_m = 1.3;
  limits.wire_max_m = 2.7;
  limits.fences = controller::FenceLimits{.arm = {0.350, 1.160, 0.250, 0.830, 2.2692},
                                          .p_base_tool_min_m = {0.5, -2.5, -1.0},
                                          .p_base_tool_max_m = {4.5, 2.5, 3.5},
                                          .load_height_min_m = 0.5,
                                          .p_world_second_m = {9, 9, 9},
                                          .distance_to_second_min_m = 1.2};
  controller::Guard guard(limits);
  controller::LeaseDesk desk;
  const auto lease = desk.grant("bench", false, LabTime{});
  controller::Guard::Inputs asked;
  asked.lease = &*lease;
  asked.X_WR = math::RigidTransform{math::Matrix3d::Identity(), {0, 0, 3}};
  asked.dt_s = 1e-3;
  asked.may_move = true;
  asked.q_rad.emplace();
  asked.wire_length_m = 2.0;
  const auto guarded = [&](const std::optional<controller::Wish>& wish) {
    asked.wish = wish;
    return guard.step(asked).qd_radps[0];
  };
  table.alone("guard, a period", calls, [&](std::size_t i) {
    controller::Wish wish;
    wish.qd_radps.fill(0.6 * std::sin(0.01 * static_cast<double>(i)));
    sink += guarded(wish);
  });
  table.alone("all three: the control step", calls, [&](std::size_t i) {
    estimate(i);
    sink += guarded(keep(i));
  });
}

int run(bool is_short) {
  Table table(is_short ? 1 : 11);
  bool all_same = kinematics(table, is_short ? 50 : 1000);
  all_same &= filter_of_10(table, is_short ? 100 : 1000);
  all_same &= filter_of_35(table, is_short ? 100 : 200);
  control_step(table, is_short ? 500 : 5000);
  std::printf("same results: %s, nothing allocated: %s, checksum %.6g\n", all_same ? "yes" : "NO",
              table.nothing_allocated() ? "yes" : "NO", sink);
  if (!is_short) std::printf("ours is the faster everywhere: %s\n", table.all_faster() ? "yes" : "NO");
  return all_same && table.nothing_allocated() && (is_short || table.all_faster()) ? 0 : 1;
}

}  // namespace
}  // namespace motionlab

int main(int argc, char** argv) {
  return motionlab::run(argc > 1 && std::strcmp(argv[1], "--short") == 0);
}
