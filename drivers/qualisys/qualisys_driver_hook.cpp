#include "drivers/qualisys/qualisys_driver_hook.hpp"

#include <algorithm>
#include <cmath>

namespace motionlab::qualisys {

namespace {

double distance_m(const UnlabelledMarker& a, const UnlabelledMarker& b) noexcept {
  const auto &p = a.p_camera_marker_m, &q = b.p_camera_marker_m;
  return std::hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]);
}

}  // namespace

BodyPose MarkerPair::find(std::span<const UnlabelledMarker> markers) noexcept {
  struct Candidate {
    const UnlabelledMarker *a, *b;
    double miss_m;
    [[nodiscard]] std::array<std::uint32_t, 2> ids() const noexcept {
      return {std::min(a->id, b->id), std::max(a->id, b->id)};
    }
  };
  std::optional<Candidate> best;
  std::size_t candidates = 0;
  bool best_is_known = false;
  for (std::size_t i = 0; i < markers.size(); ++i) {
    for (std::size_t j = i + 1; j < markers.size(); ++j) {
      const Candidate pair{&markers[i], &markers[j],
                           std::abs(distance_m(markers[i], markers[j]) - spacing_m_)};
      if (pair.miss_m > tolerance_m_) continue;
      ++candidates;
      const bool known = ids_ && pair.ids() == *ids_;
      if (best_is_known || (best && !known && pair.miss_m >= best->miss_m)) continue;
      best = pair;
      best_is_known = known;
    }
  }
  ambiguous_ = candidates > 1 && !best_is_known;
  if (!best || ambiguous_) {
    ids_.reset();
    return {};
  }
  ids_ = best->ids();
  BodyPose pose;
  pose.tracked = true;
  for (std::size_t k = 0; k < 3; ++k)
    pose.p_camera_body_m[k] = 0.5 * (best->a->p_camera_marker_m[k] + best->b->p_camera_marker_m[k]);
  pose.residual_m = best->miss_m;
  return pose;
}

void MarkerPair::reset() noexcept {
  ids_.reset();
  ambiguous_ = false;
}

}  // namespace motionlab::qualisys
