// Our serial chain against Orocos KDL's, on the six-axis arm of thesis Tab A.4: forward kinematics, the
// Jacobian, inverse kinematics to the same tolerance from the same starts. Interleaved pairs in one run,
// processor time; what is reported is the median of the ratios, theirs over ours. Fails when ours is slower.
#include <kdl/chainfksolverpos_recursive.hpp>
#include <kdl/chainiksolverpos_lma.hpp>
#include <kdl/chainjnttojacsolver.hpp>

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <vector>

#include "drivers/core/random.hpp"
#include "tests/unit/math/kdl_arm.hpp"

namespace motionlab {
namespace {

using test::Vector6;

constexpr int kPairs = 11;
constexpr double kTolerance = 1e-9;

double processor_s() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

template <class Work>
double seconds_of(const Work& work) {
  const double begin = processor_s();
  work();
  return processor_s() - begin;
}

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<long>(values.size() / 2), values.end());
  return values[values.size() / 2];
}

/// Runs both in turn and prints; returns whether ours is the faster.
template <class Ours, class Theirs>
bool compare(const char* what, std::size_t calls, const Ours& ours, const Theirs& theirs) {
  ours();
  theirs();
  std::vector<double> ratio, our_ns, their_ns;
  for (int pair = 0; pair < kPairs; ++pair) {
    const bool first = pair % 2 == 0;  // neither always finds the other's warm cache
    double a = 0, b = 0;
    if (first) a = seconds_of(ours);
    b = seconds_of(theirs);
    if (!first) a = seconds_of(ours);
    ratio.push_back(b / a);
    our_ns.push_back(1e9 * a / static_cast<double>(calls));
    their_ns.push_back(1e9 * b / static_cast<double>(calls));
  }
  std::sort(ratio.begin(), ratio.end());
  std::printf("%-24s ours %9.1f ns   KDL %9.1f ns   KDL/ours median %6.2f  (%.2f to %.2f, %d pairs)\n", what,
              median(our_ns), median(their_ns), median(ratio), ratio.front(), ratio.back(), kPairs);
  return median(ratio) > 1;
}

int run() {
  const auto arm = test::six_axis_arm(test::kTool);
  const KDL::Chain chain = test::kdl_six_axis_arm(test::kTool);
  KDL::ChainFkSolverPos_recursive kdl_forward(chain);
  KDL::ChainJntToJacSolver kdl_jacobian(chain);
  KDL::ChainIkSolverPos_LMA kdl_inverse(chain, kTolerance);
  math::InverseOptions options;
  options.position_tolerance_m = options.rotation_tolerance_rad = kTolerance / 2;

  struct Pose {
    Vector6 q, start;
    KDL::JntArray kdl_q, kdl_start;
    math::RigidTransform goal;
    KDL::Frame kdl_goal;
  };
  Random random(1);
  std::vector<Pose> poses;
  while (poses.size() < 200) {
    Pose pose;
    for (int i = 0; i < 6; ++i) {
      pose.q[i] = test::six_axis_home()[i] + random.uniform(-0.8, 0.8);
      pose.start[i] = random.uniform(-0.1, 0.1);
    }
    pose.q[4] = random.uniform(0.4, 1.2);  // clear of the wrist's singularity
    pose.start += pose.q;
    pose.kdl_q = test::table_angles(pose.q);
    pose.kdl_start = test::table_angles(pose.start);
    pose.goal = arm.tool(pose.q);
    pose.kdl_goal = test::frame(pose.goal);
    poses.push_back(pose);
  }

  double sink = 0;
  KDL::Frame X;
  KDL::Jacobian J(6);
  KDL::JntArray found(6);
  int ours_missed = 0, kdl_missed = 0;
  constexpr int kRounds = 200, kInverseRounds = 5;

  bool faster = compare(
      "forward", poses.size() * kRounds,
      [&] {
        for (int i = 0; i < kRounds; ++i) {
          for (const Pose& pose : poses) sink += arm.tool(pose.q).p.x();
        }
      },
      [&] {
        for (int i = 0; i < kRounds; ++i) {
          for (const Pose& pose : poses) {
            kdl_forward.JntToCart(pose.kdl_q, X);
            sink += X.p.x();
          }
        }
      });
  faster &= compare(
      "Jacobian", poses.size() * kRounds,
      [&] {
        for (int i = 0; i < kRounds; ++i) {
          for (const Pose& pose : poses) sink += arm.jacobian(pose.q)(0, 0);
        }
      },
      [&] {
        for (int i = 0; i < kRounds; ++i) {
          for (const Pose& pose : poses) {
            kdl_jacobian.JntToJac(pose.kdl_q, J);
            sink += J(0, 0);
          }
        }
      });
  faster &= compare(
      "inverse", poses.size() * kInverseRounds,
      [&] {
        for (int i = 0; i < kInverseRounds; ++i) {
          for (const Pose& pose : poses) {
            const auto result = arm.inverse(pose.goal, pose.start, options);
            sink += result.q[0];
            ours_missed += !result.reached;
          }
        }
      },
      [&] {
        for (int i = 0; i < kInverseRounds; ++i) {
          for (const Pose& pose : poses) {
            kdl_missed += kdl_inverse.CartToJnt(pose.kdl_start, pose.kdl_goal, found) < 0;
            sink += found(0);
          }
        }
      });
  faster &= compare(
      "forward and inverse", poses.size() * kInverseRounds,
      [&] {
        for (int i = 0; i < kInverseRounds; ++i) {
          for (const Pose& pose : poses) sink += arm.inverse(arm.tool(pose.q), pose.start, options).q[0];
        }
      },
      [&] {
        for (int i = 0; i < kInverseRounds; ++i) {
          for (const Pose& pose : poses) {
            kdl_forward.JntToCart(pose.kdl_q, X);
            kdl_inverse.CartToJnt(pose.kdl_start, X, found);
            sink += found(0);
          }
        }
      });

  const auto crane = test::crane_arm();
  const auto limits = test::strokes();
  const double closed_s = seconds_of([&] {
    for (int i = 0; i < kRounds; ++i) {
      for (const Pose& pose : poses) {
        const auto all = crane.inverse(crane.position(pose.q.head<3>()), limits);
        sink += all.elbow_up ? all.elbow_up->q[1] : 0;
      }
    }
  });
  std::printf("three axes, closed form, both branches, forward and inverse: %.1f ns\n",
              1e9 * closed_s / static_cast<double>(poses.size() * kRounds));
  std::printf("goals not reached: ours %d, KDL %d; checksum %.6g\n", ours_missed, kdl_missed, sink);
  return faster ? 0 : 1;
}

}  // namespace
}  // namespace motionlab

int main() {
  return motionlab::run();
}
