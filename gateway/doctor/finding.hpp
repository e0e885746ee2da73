/// @file  What the doctor says of one thing: how it is, and what to do about it.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace motionlab::doctor {

enum class Grade {
  pass,
  warn,  ///< works, but not as well or as safely as it could
  fail   ///< the gateway cannot do its work like this
};

[[nodiscard]] constexpr std::string_view to_string(Grade grade) noexcept {
  return grade == Grade::pass ? "pass" : grade == Grade::warn ? "warn" : "fail";
}

struct Finding {
  Grade grade = Grade::pass;
  std::string subject;  ///< stable, for programs: "clock", "port of mru1"
  std::string text;     ///< what was found
  std::string fix;      ///< what to do; empty when there is nothing to do
};

using Findings = std::vector<Finding>;

/// The worst of them; `pass` when there are none.
[[nodiscard]] constexpr Grade worst(const Findings& findings) noexcept {
  Grade grade = Grade::pass;
  for (const Finding& finding : findings) {
    if (finding.grade > grade) grade = finding.grade;
  }
  return grade;
}

}  // namespace motionlab::doctor
