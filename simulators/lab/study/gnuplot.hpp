/// @file  Plots drawn as SVG by gnuplot.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>
#include <utility>

#include "simulators/lab/study/plot.hpp"

namespace motionlab::study {

/// Size of the drawing in CSS pixels.
struct PlotSize {
  int width, height;
};
[[nodiscard]] PlotSize size_of(const Plot& plot);

/// The whole drawing as a program for gnuplot, data and all. It writes SVG to its standard output.
[[nodiscard]] std::string gnuplot_script(const Plot& plot);

/// Draws into a folder: NAME.gp, the script, and NAME.svg, what gnuplot makes of it. No shell is asked.
///
/// gnuplot draws while the caller computes the next plot; a failure is told by the next call.
class Gnuplot {
 public:
  explicit Gnuplot(std::filesystem::path folder) : folder_(std::move(folder)) {}
  ~Gnuplot();
  Gnuplot(const Gnuplot&) = delete;
  Gnuplot& operator=(const Gnuplot&) = delete;

  /// @throws StartupError when the folder cannot be written to, or gnuplot is missing or failed
  void draw(const Plot& plot, const std::string& name);
  /// Waits until all is drawn. @throws StartupError when gnuplot failed
  void finish();

 private:
  std::filesystem::path folder_;
  std::filesystem::path drawing_;  ///< the script that is being drawn
  pid_t child_ = 0;                ///< 0: none
};

}  // namespace motionlab::study
