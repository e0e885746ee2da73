/// @file  Recorded ship motion, from a table of comma-separated values.
#pragma once

#include <filesystem>
#include <istream>
#include <string_view>

#include "simulators/plant/recorded_motion.hpp"

namespace motionlab::lab {

/// Reads lines of seven numbers under a header that names them, in any order: t_s, surge_m, sway_m, heave_m
/// (positive down, like all of N), roll_deg, pitch_deg, yaw_deg. Times increase; the first is when the ship
/// begins to move. Empty lines and lines that begin with # are skipped.
/// @throws StartupError "FILE:LINE: what is wrong; what to write instead"
[[nodiscard]] plant::RecordedMotion read_motion_csv(const std::filesystem::path& file);
[[nodiscard]] plant::RecordedMotion read_motion_csv(std::istream& in, std::string_view name);

}  // namespace motionlab::lab
