/// @file  `motionlab verify`
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "gateway/monitor/session.hpp"
#include "gateway/record/inspection.hpp"

namespace motionlab::monitor {

struct VerifyCommand {
  std::string file;
  std::string repaired;  ///< where a whole file shall be written; empty: nowhere
  bool json = false;
};

/// What is in the file, in lines for people. All texts of the file are made harmless.
[[nodiscard]] std::string inspection_text(const record::Inspection& seen);
[[nodiscard]] nlohmann::ordered_json inspection_json(const record::Inspection& seen);

/// Ends with 0 when the file is whole, or a whole one could be written of what is good in it; else with 1.
/// @throws StartupError  no such file; the repaired one exists already or cannot be made
int run_verify(const VerifyCommand& command, const Terminal& terminal);

}  // namespace motionlab::monitor
