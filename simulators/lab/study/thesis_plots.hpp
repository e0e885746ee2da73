/// @file  What the thesis' figures show, computed in the world of the thesis.
#pragma once

#include <string_view>
#include <vector>

#include "simulators/lab/study/plot.hpp"

namespace motionlab::study {

/// Filters on a cart that is pushed to and fro. @param wire_m  what the load hangs on; the filters believe 2
/// m
[[nodiscard]] Plot pushed_pendulum(double wire_m);
/// The pendulum in a plane asked for 1 m. @param controller  a word of `--controller`; likewise below
[[nodiscard]] Plot pendulum_step(std::string_view controller);

/// Swing of the load below a tool that follows the sinus, and what the ten-state filter believes of it.
[[nodiscard]] Plot load_filter(bool offset_start);
/// The load below the arm and one controller: a step of 0.4 m in each axis.
[[nodiscard]] Plot load_steps(std::string_view controller);
/// One of the load's scenarios under all three controllers.
[[nodiscard]] Plot load_scenario(std::string_view scenario);

/// The ship's coordinates as measured with noise and as the 35-state filter believes them; the load's swing.
[[nodiscard]] Plot ship_filter();
[[nodiscard]] Plot swing_filter();
/// The motion system on a ship that rests: a step of 0.4 m in each axis.
[[nodiscard]] Plot motion_steps();
/// What a scenario of the motion system shows besides the swing.
struct MotionShow {
  bool tool = true;
  bool load = false;
  bool wire = false;
};
[[nodiscard]] Plot motion_scenario(std::string_view scenario, const MotionShow& show);
/// The wave without control; the swing also as it comes out in the axes of the thesis, heave upside down.
[[nodiscard]] Plot uncontrolled_wave();

/// What the tool point is asked for.
[[nodiscard]] Plot step_reference();
[[nodiscard]] Plot sinus_reference();
/// The ship's motion of Tab 4.4.
[[nodiscard]] Plot ship_wave();

}  // namespace motionlab::study
