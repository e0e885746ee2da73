/// @file  A figure before it is drawn: panels one below the other on one axis of time.
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

namespace motionlab::study {

/// How a curve is drawn. Pens differ in colour, in lightness and in their dashes: colour-blind readers and
/// grey paper tell them apart.
enum class Pen {
  truth,         ///< black
  first,         ///< blue
  second,        ///< red, dashed
  third,         ///< green, dotted
  set_point,     ///< thin grey, dashed
  uncontrolled,  ///< grey
  measured,      ///< grey points
};

/// Values at the plot's times. A value that is not a number leaves a gap.
struct Curve {
  std::string legend;
  Pen pen = Pen::first;
  std::vector<double> y;
};

enum class Scale { linear, logarithmic };

struct Panel {
  std::string axis;  ///< what is plotted, with its unit in brackets
  std::vector<Curve> curves;
  Scale scale = Scale::linear;
  /// The axis spans at least this much (logarithmic: it begins here), so that noise does not look like news.
  double least = 0;
};

/// Something that happens: a line through all panels.
struct PlotEvent {
  double t_s = 0;
  std::string name;
};

struct Plot {
  std::string title;
  std::vector<double> t_s;
  std::vector<Panel> panels;
  std::vector<PlotEvent> events;
};

/// So many points a curve has, about: more than a screen has columns only make files large.
constexpr std::int64_t kPlotPoints = 800;

constexpr double kGap = std::numeric_limits<double>::quiet_NaN();

}  // namespace motionlab::study
