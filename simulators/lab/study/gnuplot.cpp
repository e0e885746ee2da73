#include "simulators/lab/study/gnuplot.hpp"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <limits>
#include <string_view>

#include "drivers/core/error.hpp"

namespace motionlab::study {
namespace {

// In CSS pixels.
constexpr int kWidth = 760, kPanel = 120, kBetween = 18, kAbove = 46, kEventName = 16, kBelow = 50;
constexpr int kLeft = 78, kRight = 222, kToLegend = 12;

/// Okabe and Ito's colours, from dark to light, each with dashes of its own.
std::string_view style(Pen pen) {
  switch (pen) {
    case Pen::truth:
      return "lines lw 1.6 lc rgb '#000000' dt solid";
    case Pen::first:
      return "lines lw 1.9 lc rgb '#0072B2' dt solid";
    case Pen::second:
      return "lines lw 1.9 lc rgb '#D55E00' dt (9,4)";
    case Pen::third:
      return "lines lw 2.2 lc rgb '#009E73' dt (2,3)";
    case Pen::set_point:
      return "lines lw 1.4 lc rgb '#555555' dt (5,3)";
    case Pen::uncontrolled:
      return "lines lw 1.6 lc rgb '#999999' dt solid";
    case Pen::measured:
      return "points pt 7 ps 0.25 lc rgb '#AAAAAA'";
  }
  return "";
}

/// A string of gnuplot's without any special meaning inside.
std::string literal(std::string_view text) {
  std::string out = "'";
  for (const char c : text) out.append(c == '\'' ? "''" : std::string(1, c));
  return out + "'";
}

std::string number(double value) {
  if (!std::isfinite(value)) return "?";
  std::array<char, 32> text;
  const int length = std::snprintf(text.data(), text.size(), "%.5g", value);
  return {text.data(), static_cast<std::size_t>(length)};
}

std::string data(const Plot& plot) {
  std::string out = "$data << end\n";
  for (std::size_t i = 0; i < plot.t_s.size(); ++i) {
    out += number(plot.t_s[i]);
    for (const Panel& panel : plot.panels) {
      for (const Curve& curve : panel.curves) out += ' ' + number(curve.y[i]);
    }
    out += '\n';
  }
  return out + "end\n";
}

/// A distance between tics of which some five fit: 1, 2 or 5 times a power of ten.
double tics(double span) {
  const double least = span / 6, power = std::pow(10.0, std::floor(std::log10(least)));
  for (const double step : {1.0, 2.0, 5.0}) {
    if (step * power >= least) return step * power;
  }
  return 10 * power;
}

/// The axis for all that is drawn, with a little air, and no less than `panel.least`.
std::string y_axis(const Panel& panel) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const Curve& curve : panel.curves) {
    for (const double y : curve.y) {
      if (!std::isfinite(y)) continue;
      low = std::min(low, y);
      high = std::max(high, y);
    }
  }
  if (low > high) low = high = 0;
  if (panel.scale == Scale::logarithmic) {
    return "set logscale y\nset ytics 10\nset yrange [" + number(panel.least) + ':' +
           number(std::max(1.5 * high, 10 * panel.least)) + "]\n";
  }
  const double half = std::max(0.54 * (high - low), 0.5 * panel.least), middle = 0.5 * (low + high);
  return "unset logscale y\nset ytics " + number(tics(2 * half)) + "\nset yrange [" + number(middle - half) +
         ':' + number(middle + half) + "]\n";
}

int above(const Plot& plot) {
  return plot.events.empty() ? kAbove : kAbove + kEventName;
}

/// The last sample stands for the time until there would be another.
double end_s(const Plot& plot) {
  const std::size_t n = plot.t_s.size();
  return n < 2 ? 1 : 2 * plot.t_s[n - 1] - plot.t_s[n - 2];
}

/// A legend is not told twice, one panel below the other.
bool same_legend(const Panel& a, const Panel& b) {
  return std::equal(a.curves.begin(), a.curves.end(), b.curves.begin(), b.curves.end(),
                    [](const Curve& c, const Curve& d) { return c.legend == d.legend && c.pen == d.pen; });
}

[[noreturn]] void cannot_write(const std::filesystem::path& path) {
  throw StartupError("cannot write " + path.string() + "; choose a folder that is writable");
}

int exit_status(pid_t child) {
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return status;
}

}  // namespace

PlotSize size_of(const Plot& plot) {
  const int panels = static_cast<int>(plot.panels.size());
  return {kWidth, above(plot) + panels * kPanel + (panels - 1) * kBetween + kBelow};
}

std::string gnuplot_script(const Plot& plot) {
  const PlotSize size = size_of(plot);
  // gnuplot counts screens from the lower left corner.
  const auto on_width = [&](int pixels) { return number(static_cast<double>(pixels) / size.width); };
  const auto on_height = [&](int pixels) { return number(1 - static_cast<double>(pixels) / size.height); };
  std::string out = "set encoding utf8\nset datafile missing '?'\n";
  out += "set terminal svg noenhanced size " + std::to_string(size.width) + ',' +
         std::to_string(size.height) + " font 'sans-serif,12' background '#FFFFFF'\n";
  out += data(plot);
  out += "set multiplot\nset label 1 " + literal(plot.title) + " at screen 0.5," + on_height(22) +
         " center font 'sans-serif,14'\n";
  out += "set lmargin at screen " + on_width(kLeft) + "\nset rmargin at screen " +
         on_width(size.width - kRight) + '\n';
  out += "set grid lw 0.8 lc rgb '#DDDDDD' dt solid\nset border lw 0.8 lc rgb '#444444'\n";
  out += "set tics nomirror scale 0.5\nset xrange [0:" + number(end_s(plot)) + "]\n";
  for (const PlotEvent& event : plot.events) {
    const std::string t = number(event.t_s);
    out +=
        "set arrow from " + t + ", graph 0 to " + t + ", graph 1 nohead lw 1.2 lc rgb '#444444' dt (2,2)\n";
    out += "set label " + literal(event.name) + " at " + t + ", graph 1.08 center\n";
  }
  int top = above(plot);
  std::size_t column = 2;
  for (const Panel& panel : plot.panels) {
    const bool first = &panel == &plot.panels.front(), last = &panel == &plot.panels.back();
    out += "set tmargin at screen " + on_height(top) + "\nset bmargin at screen " + on_height(top + kPanel) +
           '\n';
    if (!first && same_legend(panel, *(&panel - 1))) {
      out += "unset key\n";
    } else {
      out += "set key at screen " + on_width(size.width - kRight + kToLegend) + ", screen " + on_height(top) +
             " left top vertical Left reverse samplen 2.5 spacing 1.15\n";
    }
    out += last ? "set format x '%g'\nset xlabel 'time [s]' offset 0,0.5\n" : "set format x ''\n";
    out += "set ylabel " + literal(panel.axis) + "\n" + y_axis(panel);
    std::string_view before = "plot ";
    for (const Curve& curve : panel.curves) {
      out.append(before).append("$data using 1:").append(std::to_string(column++)).append(" with ");
      out.append(style(curve.pen)).append(" title ").append(literal(curve.legend));
      before = ", \\\n     ";
    }
    out += "\nunset label\n";
    top += kPanel + kBetween;
  }
  return out + "unset multiplot\n";
}

Gnuplot::~Gnuplot() {
  if (child_ != 0) (void)exit_status(child_);
}

void Gnuplot::draw(const Plot& plot, const std::string& name) {
  const auto script = folder_ / (name + ".gp"), picture = folder_ / (name + ".svg");
  std::ofstream file(script, std::ios::binary);
  file << gnuplot_script(plot);
  file.close();
  if (!file) cannot_write(script);
  // posix_spawn cannot tell a file that it could not open from a program that it could not find.
  if (!std::ofstream(picture, std::ios::binary)) cannot_write(picture);
  finish();

  posix_spawn_file_actions_t files;
  ::posix_spawn_file_actions_init(&files);
  ::posix_spawn_file_actions_addopen(&files, STDIN_FILENO, script.c_str(), O_RDONLY, 0);
  ::posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, picture.c_str(), O_WRONLY | O_TRUNC, 0);
  std::array<char, 8> program{"gnuplot"};
  std::array<char, 3> own_settings_only{"-d"};
  const std::array<char*, 3> arguments{program.data(), own_settings_only.data(), nullptr};
  const int problem = ::posix_spawnp(&child_, program.data(), &files, nullptr, arguments.data(), environ);
  ::posix_spawn_file_actions_destroy(&files);
  if (problem != 0) {
    child_ = 0;
    throw StartupError(std::string("cannot run gnuplot: ") + std::strerror(problem) +
                       "; install it (Debian: gnuplot-nox)");
  }
  drawing_ = script;
}

void Gnuplot::finish() {
  if (child_ == 0) return;
  const int status = exit_status(std::exchange(child_, 0));
  if (status != 0) {
    throw StartupError("gnuplot could not draw " + drawing_.string() +
                       "; see what it says above, or run: gnuplot -d < " + drawing_.string());
  }
}

}  // namespace motionlab::study
