/// @file  A finding by its subject.
#pragma once

#include <algorithm>
#include <string_view>

#include "gateway/doctor/finding.hpp"

namespace motionlab::doctor {

inline const Finding* find(const Findings& findings, std::string_view subject) {
  const auto found = std::ranges::find(findings, subject, &Finding::subject);
  return found == findings.end() ? nullptr : &*found;
}

}  // namespace motionlab::doctor
