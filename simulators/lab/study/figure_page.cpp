#include "simulators/lab/study/figure_page.hpp"

#include <algorithm>
#include <string_view>

#include "simulators/lab/study/gnuplot.hpp"

namespace motionlab::study {
namespace {

constexpr std::string_view kHead = R"(<!DOCTYPE html>
<html lang="en" xmlns="http://www.w3.org/1999/xhtml">
<head>
<meta charset="utf-8"/>
<meta name="viewport" content="width=device-width, initial-scale=1"/>
<title>The load kept still: the thesis' figures and ours</title>
<style>
body { margin: 0 auto; max-width: 1580px; padding: 1.5rem; font: 16px/1.5 system-ui, sans-serif; color: #1a1a1a; background: #f4f5f6; }
h1, h2, p { max-width: 75ch; }
h2 { margin-top: 2.5rem; }
.figures { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(100%, 640px), 1fr)); gap: 1.25rem; align-items: start; }
figure { margin: 0; padding: .75rem; background: #fff; border: 1px solid #d5d8db; border-radius: 4px; }
figure.ours { border: 2px solid #0072b2; }
img { display: block; width: 100%; height: auto; }
figcaption { padding: .5rem .25rem 0; }
</style>
</head>
<body>
<h1>The load kept still: the thesis' figures and ours</h1>
<p>Figures of "Simulation and Control of an Anti-Swing System for a Suspended Load attached to a moving Base Robot"
(University of Agder), computed anew with the thesis' models, filters and controllers, mistakes corrected; and, framed in
blue, this gateway's in the simulated laboratory: elastic wire, lagging joints, late and noisy sensors, a calibration that
is a little wrong. Figures 4.23, 4.25, 4.26, 4.28, 4.32, 4.34, 4.35 and 4.37 are block diagrams and have no counterpart.</p>
<p>α and β are the swing angles against gravity. FPF: state feedback with pre-filter; IC: with integral; NL: virtual damper.
A figure opens in full size when clicked; the file of the same name with the ending <code>gp</code> holds its data and
draws it again: <code>gnuplot -d &lt; NAME.gp &gt; NAME.svg</code>.</p>
)";

std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

/// What is plotted, for those who cannot see it.
std::string alternative(const Plot& plot) {
  std::string out = plot.title + ". Over time:";
  std::vector<std::string> legends;
  for (const Panel& panel : plot.panels) {
    out += (&panel == &plot.panels.front() ? " " : ", ") + panel.axis;
    for (const Curve& curve : panel.curves) {
      if (!curve.legend.empty() && std::find(legends.begin(), legends.end(), curve.legend) == legends.end()) {
        legends.push_back(curve.legend);
      }
    }
  }
  out += ". Curves:";
  for (const auto& legend : legends) out += (&legend == &legends.front() ? " " : "; ") + legend;
  return out + ".";
}

std::string element(const ShownFigure& figure) {
  const PlotSize size = size_of(figure.plot);
  const bool ours = figure.number == "Ours";
  return std::string(ours ? "<figure class=\"ours\" id=\"" : "<figure id=\"") + figure.name +
         "\">\n<a href=\"" + figure.name + ".svg\"><img src=\"" + figure.name + ".svg\" width=\"" +
         std::to_string(size.width) + "\" height=\"" + std::to_string(size.height) + "\" alt=\"" +
         escaped(alternative(figure.plot)) + "\"/></a>\n<figcaption><b>" + escaped(figure.number) + ".</b> " +
         escaped(figure.seen) + "</figcaption>\n</figure>\n";
}

}  // namespace

std::string figure_page(const std::vector<PageSection>& sections) {
  std::string out(kHead);
  for (const PageSection& section : sections) {
    out += "<h2>" + escaped(section.title) + "</h2>\n<p>" + escaped(section.about) +
           "</p>\n<div class=\"figures\">\n";
    for (const ShownFigure& figure : section.figures) out += element(figure);
    out += "</div>\n";
  }
  return out + "</body>\n</html>\n";
}

}  // namespace motionlab::study
