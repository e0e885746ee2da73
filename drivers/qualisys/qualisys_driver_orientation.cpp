#include "drivers/qualisys/qualisys_driver_orientation.hpp"

#include <algorithm>
#include <cmath>

#include "drivers/qualisys/qualisys_wire_rotation.hpp"

namespace motionlab::qualisys {

namespace {

using Verdict = OrientationCheck::Verdict;

/// Both forms are single precision of the same measurement.
constexpr double kTolerance = 2e-3;
/// A matrix and its transpose must differ by more than this to be told apart.
constexpr double kAskew = 0.05;

/// Greatest difference of an element of `a` from `b`, or from the transpose of `b`.
double difference(const Matrix& a, const Matrix& b, bool transposed) noexcept {
  double greatest = 0.0;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      greatest = std::max(greatest, std::abs(a[i][j] - (transposed ? b[j][i] : b[i][j])));
  return greatest;
}

Verdict compare(const BodyPose& pose, const BodyAngles& angles) noexcept {
  if (!pose.tracked || !angles.tracked) return Verdict::undecided;
  const Matrix r = to_matrix(pose.q_camera_body);
  const Matrix expected = from_angles(angles.angles_rad);
  if (difference(r, expected, false) <= kTolerance)
    return difference(r, r, true) > kAskew ? Verdict::agree : Verdict::undecided;
  return difference(r, expected, true) <= kTolerance ? Verdict::transposed : Verdict::disagree;
}

}  // namespace

bool OrientationCheck::judge(const DataFrame& frame) noexcept {
  Verdict verdict = Verdict::undecided;
  const auto poses = frame.bodies.view();
  const auto angles = frame.angles.view();
  for (std::size_t i = 0; i < std::min(poses.size(), angles.size()); ++i)
    verdict = std::max(verdict, compare(poses[i], angles[i]));
  const bool changed = verdict != verdict_;
  verdict_ = verdict;
  return changed;
}

std::string_view OrientationCheck::advice() const noexcept {
  switch (verdict_) {
    case Verdict::transposed:
      return "matrix and Euler angles disagree: QTM writes matrices by rows, we read them by columns; "
             "orientations are "
             "wrong, do not engage";
    case Verdict::disagree:
      return "matrix and Euler angles disagree: set the Euler angles of the QTM project to Qualisys "
             "standard, then "
             "this check can tell";
    default:
      return {};
  }
}

}  // namespace motionlab::qualisys
