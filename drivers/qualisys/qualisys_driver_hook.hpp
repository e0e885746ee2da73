/// @file  Where the hook is, from two markers on it that carry no label.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "drivers/qualisys/qualisys_wire_data.hpp"

namespace motionlab::qualisys {

struct HookConfig {
  std::string name;  ///< of the body that stands for the hook on the topics; empty: no hook is looked for
  double spacing_m = 0.062;  ///< between the two markers
  double tolerance_m =
      0.005;  ///< by how much a pair may miss it; one of the laboratory's recordings has 59.2 mm
};

/// Finds the pair of markers whose spacing is nearest to that of the hook.
///
/// A pair that was found keeps being taken while both its markers keep their numbers, so that markers which
/// come and go elsewhere do not make the hook jump. Without such a history two different pairs within the
/// tolerance are ambiguous: then the hook is lost rather than guessed.
class MarkerPair {
 public:
  explicit MarkerPair(const HookConfig& config) noexcept
      : spacing_m_(config.spacing_m), tolerance_m_(config.tolerance_m) {}

  /// The hook's pose: the midpoint, in the camera system's frame. Two points have no orientation: the
  /// quaternion is all zero. The residual is how far the spacing misses.
  [[nodiscard]] BodyPose find(std::span<const UnlabelledMarker> markers) noexcept;
  /// The last call found more than one pair and could not tell which is the hook.
  [[nodiscard]] bool ambiguous() const noexcept { return ambiguous_; }
  void reset() noexcept;

 private:
  double spacing_m_;
  double tolerance_m_;
  std::optional<std::array<std::uint32_t, 2>> ids_;  ///< of the last pair, the smaller first
  bool ambiguous_ = false;
};

}  // namespace motionlab::qualisys
