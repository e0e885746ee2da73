// What the driver is made of: the order of packets, the hook of two markers, the check of orientations.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "drivers/qualisys/qualisys_driver_hook.hpp"
#include "drivers/qualisys/qualisys_driver_order.hpp"
#include "drivers/qualisys/qualisys_driver_orientation.hpp"
#include "drivers/qualisys/qualisys_wire_rotation.hpp"

namespace motionlab::qualisys {
namespace {

DataFrame packet(std::uint64_t timestamp_us, std::uint32_t number,
                 Components present = {Component::bodies_res}) {
  DataFrame p;
  p.timestamp_us = timestamp_us;
  p.frame_number = number;
  p.present = present;
  return p;
}

TEST(QualisysOrder, TakesTheFurtherPartsOfAFrameOnce) {
  FrameOrder order;
  EXPECT_TRUE(order.judge(packet(5000, 1)).first_part);
  const auto part = order.judge(packet(5000, 1, {Component::unlabelled}));
  EXPECT_FALSE(part.fault);
  EXPECT_FALSE(part.first_part);
  EXPECT_EQ(order.judge(packet(5000, 1, {Component::unlabelled})).fault->reason, Reason::duplicate);
  EXPECT_EQ(order.judge(packet(5000, 1, {Component::unlabelled, Component::timecode})).fault->reason,
            Reason::duplicate);
  EXPECT_EQ(order.judge(packet(5000, 2, {Component::timecode})).fault->reason, Reason::duplicate)
      << "another number is no part of this frame";
  EXPECT_TRUE(order.judge(packet(10000, 2, {Component::unlabelled})).first_part);
}

TEST(QualisysOrder, RefusesALatePartOfAnOlderFrame) {
  FrameOrder order;
  (void)order.judge(packet(5000, 1));
  (void)order.judge(packet(10000, 2));
  EXPECT_EQ(order.judge(packet(5000, 1, {Component::unlabelled})).fault->reason, Reason::out_of_order);
}

TEST(QualisysOrder, CountsMissingFramesButNotOverARestart) {
  FrameOrder order;
  (void)order.judge(packet(900'000'000, 100));
  EXPECT_EQ(order.judge(packet(900'005'000, 104)).lost, 3u);
  EXPECT_TRUE(order.judge(packet(0, 500)).fault);
  const auto restart = order.judge(packet(5000, 501));
  EXPECT_TRUE(restart.restarted && restart.first_part);
  EXPECT_EQ(restart.lost, 0u);
}

TEST(QualisysOrder, CountsNoMoreMissingFramesThanTimeAllows) {
  FrameOrder order;
  (void)order.judge(packet(900'000'000, 100));
  EXPECT_EQ(order.judge(packet(900'005'000, 101 | 1u << 29)).lost, 0u) << "a bit was flipped on the way";
  EXPECT_EQ(order.judge(packet(900'010'000, 102)).lost, 0u);
  EXPECT_EQ(order.judge(packet(910'010'000, 2102)).lost, 1999u) << "ten seconds of silence";
}

UnlabelledMarker marker(std::uint32_t id, double x_m, double y_m, double z_m) {
  return {{x_m, y_m, z_m}, id, 0.0};
}

TEST(QualisysHook, IsTheMidpointOfThePairWithItsSpacing) {
  MarkerPair pair{{.name = "hook"}};
  const std::vector<UnlabelledMarker> seen = {marker(9, 5, 5, 5), marker(3, 1.0, 2.0, 3.0),
                                              marker(1, 1.0, 2.061, 3.0), marker(4, 1.0, 2.3, 3.0)};
  const BodyPose hook = pair.find(seen);
  ASSERT_TRUE(hook.tracked);
  EXPECT_DOUBLE_EQ(hook.p_camera_body_m[0], 1.0);
  EXPECT_DOUBLE_EQ(hook.p_camera_body_m[1], 2.0305);
  EXPECT_DOUBLE_EQ(hook.p_camera_body_m[2], 3.0);
  EXPECT_NEAR(hook.residual_m, 0.001, 1e-12) << "by how much the spacing misses";
  EXPECT_EQ(hook.q_camera_body, (std::array<double, 4>{})) << "two points have no orientation";
}

TEST(QualisysHook, TakesThePublishedRecordingOf59mmButNothingBeyondItsTolerance) {
  MarkerPair pair{{.name = "hook"}};
  EXPECT_TRUE(pair.find(std::vector{marker(1, 0, 0, 0), marker(2, 0, 0, 0.0592)}).tracked);
  EXPECT_FALSE(pair.find(std::vector{marker(1, 0, 0, 0), marker(2, 0, 0, 0.0568)}).tracked);
  EXPECT_FALSE(pair.find(std::vector{marker(1, 0, 0, 0), marker(2, 0, 0, 0.0672)}).tracked);
  EXPECT_FALSE(pair.find(std::vector{marker(1, 0, 0, 0)}).tracked);
  EXPECT_FALSE(pair.find({}).tracked);
  EXPECT_FALSE(pair.ambiguous());
}

TEST(QualisysHook, DoesNotGuessBetweenTwoPairs) {
  MarkerPair pair{{.name = "hook"}};
  const std::vector<UnlabelledMarker> two = {marker(1, 0, 0, 0), marker(2, 0, 0, 0.062), marker(3, 1, 0, 0),
                                             marker(4, 1, 0, 0.060)};
  EXPECT_FALSE(pair.find(two).tracked);
  EXPECT_TRUE(pair.ambiguous());
  EXPECT_TRUE(pair.find(std::span{two}.last(2)).tracked);
  EXPECT_FALSE(pair.ambiguous());
}

TEST(QualisysHook, StaysWithItsPairWhenABetterOneAppears) {
  MarkerPair pair{{.name = "hook"}};
  const std::vector<UnlabelledMarker> two = {marker(3, 1, 0, 0), marker(4, 1, 0, 0.060),
                                             marker(2, 0, 0, 0.062), marker(1, 0, 0, 0)};
  ASSERT_TRUE(pair.find(std::span{two}.first(2)).tracked);
  const BodyPose hook = pair.find(two);
  ASSERT_TRUE(hook.tracked);
  EXPECT_DOUBLE_EQ(hook.p_camera_body_m[0], 1.0);
  pair.reset();
  EXPECT_FALSE(pair.find(two).tracked) << "without a history it may be either";
}

/// A frame of one body with this matrix and these angles.
DataFrame both(const Matrix& r, const std::array<double, 3>& angles_rad) {
  DataFrame frame;
  frame.bodies.size = frame.angles.size = 1;
  frame.bodies.all[0] = {true, {}, to_quaternion(r), 0.0};
  frame.angles.all[0] = {true, {}, angles_rad, 0.0};
  return frame;
}

// Published with the definition of the angles: roll 10, pitch 20, yaw 30 deg, columns one after another.
constexpr std::array<double, 9> kPublished = {0.813798, 0.543838, -0.204874, -0.469846, 0.823173,
                                              0.318796, 0.342020, -0.163176, 0.925417};
constexpr double kDegree = std::numbers::pi / 180.0;
const std::array<double, 3> kPublishedAngles = {10 * kDegree, 20 * kDegree, 30 * kDegree};

Matrix published(bool by_rows) {
  Matrix r;
  for (std::size_t k = 0; k < 9; ++k) (by_rows ? r[k / 3][k % 3] : r[k % 3][k / 3]) = kPublished[k];
  return r;
}

TEST(QualisysRotation, AgreesWithThePublishedAngles) {
  const auto angles = to_angles(published(false));
  const Matrix r = from_angles(kPublishedAngles);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(angles[i], kPublishedAngles[i], 2e-6);
    for (std::size_t j = 0; j < 3; ++j) EXPECT_NEAR(r[i][j], published(false)[i][j], 1e-6);
  }
}

using Verdict = OrientationCheck::Verdict;

TEST(QualisysOrientationCheck, TellsTheOrderOfAMatrixFromTheAngles) {
  OrientationCheck check;
  EXPECT_TRUE(check.judge(both(published(false), kPublishedAngles)));
  EXPECT_EQ(check.verdict(), Verdict::agree);
  EXPECT_EQ(check.advice(), "");
  check.reset();
  check.judge(both(published(true), kPublishedAngles));
  EXPECT_EQ(check.verdict(), Verdict::transposed);
  EXPECT_THAT(std::string{check.advice()}, testing::HasSubstr("by rows"));
  check.reset();
  check.judge(both(published(false), {0.5, 0.0, 0.0}));
  EXPECT_EQ(check.verdict(), Verdict::disagree);
  EXPECT_THAT(std::string{check.advice()}, testing::HasSubstr("Qualisys standard"));
}

TEST(QualisysOrientationCheck, DecidesNothingByABodyThatIsUprightOrLost) {
  OrientationCheck check;
  EXPECT_FALSE(check.judge(both(from_angles({}), {})));
  EXPECT_FALSE(check.judge(both(from_angles({0.01, 0.0, 0.0}), {0.01, 0.0, 0.0})));
  DataFrame lost = both(published(true), kPublishedAngles);
  lost.bodies.all[0].tracked = false;
  EXPECT_FALSE(check.judge(lost));
  EXPECT_EQ(check.verdict(), Verdict::undecided);
}

TEST(QualisysOrientationCheck, AsksOnceASecondUntilItKnows) {
  OrientationCheck check;
  const LabTime t{10s};
  EXPECT_TRUE(check.due(t));
  check.asked(t);
  EXPECT_FALSE(check.due(t + 999ms));
  EXPECT_TRUE(check.due(t + 1s));
  check.judge(both(published(false), kPublishedAngles));
  EXPECT_FALSE(check.due(t + 5s));
}

}  // namespace
}  // namespace motionlab::qualisys
