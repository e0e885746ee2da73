/// @file  Single values of the configuration files, given on the command line.
#pragma once

#include <string>
#include <vector>

#include "drivers/core/toml_reader.hpp"

namespace motionlab::lab {

/// What is to be laid over world.toml and over lab.toml. Checked like the files when they are read.
struct Settings {
  std::vector<TomlText> world;
  std::vector<TomlText> lab;

  /// Parses `world.TABLE.KEY=VALUE` and `lab.TABLE.KEY=VALUE`: "world.load.mass_kg=36",
  /// "lab.arm.servo_omega_radps=30", "lab.comau.watchdog=relay" (words need no quotes), "world.arm.flexible=
  /// false", "world.mru1.acceleration_bias_mps2=[0, 0, 0]".
  /// @throws StartupError that names the text and shows the wanted form
  static Settings parse(const std::vector<std::string>& texts);
};

}  // namespace motionlab::lab
