/// @file  The XML of `GetParameters`: which bodies and labels there are, in the order of the data; and the
/// XML by which a master sets them. Source: QTM RT Protocol documentation, "6D XML parameters", "3D XML
/// parameters", "General XML parameters".
#pragma once

#include <optional>
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

/// Reads `The_6D/Body` with `Name` and `Enabled` and passes over all else, so every version's layout will do.
/// A document without `The_6D` has no bodies; a body without a name keeps its slot.
/// Faults: bad_header (not XML, or another root), too_long (more than kMaxBodies). Allocates: not for the
/// steady path.
[[nodiscard]] Result<std::vector<BodyDefinition>> parse_bodies_xml(std::string_view xml);

/// Reads what a master wants to set: the list of bodies, if the document has one; the rest is passed over.
/// Faults: bad_header (not XML, or another root than `QTM_Settings`), too_long.
[[nodiscard]] Result<std::optional<std::vector<BodyDefinition>>> parse_settings_xml(std::string_view xml);

/// What the server's XML shall contain.
struct XmlContent {
  int version_minor = 25;  ///< the negotiated protocol 1.n; the 6D layout changed with 1.21
  double rate_hz = 200.0;
  bool general = false;
  bool bodies = false;
  bool markers = false;
  std::span<const BodyDefinition> body_list{};
  std::span<const std::string> labels{};
};

/// Writes the answer to `GetParameters`, complete enough for the vendor's clients: they refuse a body without
/// points, origin and orientation, and a `General` without time base and processing actions.
[[nodiscard]] std::string write_parameters_xml(const XmlContent& content);

}  // namespace motionlab::qualisys
