#include "simulators/lab/study/reference_plan.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <numbers>

namespace motionlab::study {

namespace {

using Eigen::Vector3d;

constexpr double kTurn = 2 * std::numbers::pi;

/// @param moving  s since it began
Vector3d stepped(double moving) {
  if (moving >= 60) return Vector3d::Zero();
  return {moving >= 0 ? 0.15 : 0.0, moving >= 20 ? 0.15 : 0.0, moving >= 40 ? -0.2 : 0.0};
}

}  // namespace

ReferencePlan::ReferencePlan(std::string_view name, topic::ReferenceFrame frame, const Vector3d& p_WL,
                             double begins_s)
    : kind_(static_cast<Kind>(std::distance(std::begin(kNames), std::ranges::find(kNames, name)))),
      frame_(frame),
      p_WL_(p_WL),
      begins_s_(begins_s),
      told_{p_WL, Vector3d::Zero(), topic::ReferenceFrame::world} {}

ReferencePlan::Place ReferencePlan::at(LabTime t) const {
  const double moving = seconds(t.time_since_epoch()) - begins_s_;
  Place place{p_WL_, Vector3d::Zero(), moving < 0 ? topic::ReferenceFrame::world : frame_};
  if (kind_ == Kind::step) place.p_WL += stepped(moving);
  if (moving < 0 || kind_ == Kind::hold || kind_ == Kind::step) return place;
  if (kind_ == Kind::sine) {
    const Vector3d size(0.10, 0.08, 0.10), omega = kTurn * Vector3d(0.05, 0.07, 0.04);
    for (int i = 0; i < 3; ++i) {
      place.p_WL[i] += size[i] * std::sin(omega[i] * moving);
      place.v_WL[i] = size[i] * omega[i] * std::cos(omega[i] * moving);
    }
  } else {
    constexpr double kRadius = 0.12, kOmega = kTurn / 30;
    const double phase = kOmega * moving;
    place.p_WL += kRadius * Vector3d(std::sin(phase), 1 - std::cos(phase), 0);
    place.v_WL = kRadius * kOmega * Vector3d(std::cos(phase), std::sin(phase), 0);
  }
  return place;
}

std::optional<topic::Reference> ReferencePlan::next(LabTime t) {
  if (t < due_) return std::nullopt;
  due_ = t + (kind_ == Kind::follow ? 100ms : 10ms);
  const Place place = at(t);
  const bool as_told = told_.p_WL == place.p_WL && told_.v_WL == place.v_WL && told_.frame == place.frame;
  if (as_told) return std::nullopt;
  told_ = place;
  topic::Reference reference;
  reference.sequence_number = ++sent_;
  reference.t_created_ns = to_ns(t);
  reference.requester = "study";
  reference.frame = place.frame;
  Eigen::Map<Vector3d>(reference.p_world_load_m.data()) = place.p_WL;
  Eigen::Map<Vector3d>(reference.v_world_load_mps.data()) = place.v_WL;
  return reference;
}

}  // namespace motionlab::study
