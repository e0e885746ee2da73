/// @file  Plots drawn as SVG by gnuplot.
#pragma once

#include <filesystem>
#include <string>

#include "simulators/lab/study/plot.hpp"

namespace motionlab::study {

/// Size of the drawing in CSS pixels.
struct PlotSize {
  int width, height;
};
[[nodiscard]] PlotSize size_of(const Plot& plot);

/// The whole drawing as a program for gnuplot, data and all. It writes SVG to its standard output.
[[nodiscard]] std::string gnuplot_script(const Plot& plot);

/// Writes NAME.gp, the script, and NAME.svg, what gnuplot makes of it. No shell is asked.
/// @throws StartupError when the folder cannot be written to, or gnuplot is missing or fails
void draw(const Plot& plot, const std::filesystem::path& folder, const std::string& name);

}  // namespace motionlab::study
