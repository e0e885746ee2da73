/// @file  The XML of `GetParameters`: which bodies there are, in the order of the data.
/// Source: QTM RT Protocol documentation, "6D XML parameters", "General XML parameters".
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/core/result.hpp"

namespace motionlab::qualisys {

/// One body of the camera system's list. A disabled one keeps its slot in the data.
struct BodyDefinition {
  std::string name;
  bool enabled = true;

  bool operator==(const BodyDefinition&) const = default;
};

/// Names are compared without regard to (ASCII) case, as people type them.
[[nodiscard]] bool same_name(std::string_view a, std::string_view b) noexcept;

/// Reads `The_6D/Body` with `Name` and `Enabled` and passes over all else, so every version's layout will do.
/// A document without `The_6D` has no bodies; a body without a name keeps its slot.
/// Faults: bad_header (not XML, or another root), too_long (more than kMaxBodies). Allocates: not for the
/// steady path.
[[nodiscard]] Result<std::vector<BodyDefinition>> parse_bodies_xml(std::string_view xml);

/// What the server's XML shall contain.
struct XmlContent {
  int version_minor = 25;  ///< the negotiated protocol 1.n; the 6D layout changed with 1.21
  double rate_hz = 200.0;
  bool general = false;
  bool bodies = false;
  std::span<const BodyDefinition> body_list{};
};

/// Writes the answer to `GetParameters`, complete enough for the vendor's clients: they refuse a body without
/// points, origin and orientation, and a `General` without time base and processing actions.
[[nodiscard]] std::string write_parameters_xml(const XmlContent& content);

}  // namespace motionlab::qualisys
