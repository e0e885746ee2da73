#include "simulators/lab/motion_csv.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "drivers/core/error.hpp"

namespace motionlab::lab {

namespace {

constexpr std::size_t kColumns = 7;
constexpr std::array<std::string_view, kColumns> kNames{"t_s",      "surge_m",   "sway_m", "heave_m",
                                                        "roll_deg", "pitch_deg", "yaw_deg"};
constexpr std::string_view kHeader = "t_s,surge_m,sway_m,heave_m,roll_deg,pitch_deg,yaw_deg";
/// Fewer rows make no motion; from there on the spline bends.
constexpr std::size_t kFewest = 4;

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlank = " \t\r";
  const auto first = text.find_first_not_of(kBlank);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlank) - first + 1);
}

std::vector<std::string_view> cells(std::string_view line) {
  std::vector<std::string_view> found;
  while (true) {
    const auto comma = line.find(',');
    found.push_back(trimmed(line.substr(0, comma)));
    if (comma == std::string_view::npos) return found;
    line.remove_prefix(comma + 1);
  }
}

std::optional<double> number(std::string_view text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

/// Which of kNames stands in each column.
using Order = std::array<std::size_t, kColumns>;

class Reader {
 public:
  explicit Reader(std::string_view name) : name_(name) {}

  void take(std::string_view line) {
    ++line_;
    if (line.starts_with("\xef\xbb\xbf")) line.remove_prefix(3);  // of spreadsheets
    line = trimmed(line);
    if (line.empty() || line.front() == '#') return;
    if (!order_) {
      take_header(cells(line));
    } else {
      take_row(cells(line));
    }
  }

  plant::RecordedMotion finish() {
    if (!order_) fail("the file is empty; begin with the header " + std::string(kHeader));
    if (samples_.size() < kFewest) {
      fail("only " + std::to_string(samples_.size()) + " rows; a motion needs at least " +
           std::to_string(kFewest));
    }
    return plant::RecordedMotion(std::move(samples_));
  }

 private:
  [[noreturn]] void fail(const std::string& why) const {
    throw StartupError(std::string(name_) + ":" + std::to_string(line_) + ": " + why);
  }

  void take_header(const std::vector<std::string_view>& names) {
    Order order{};
    for (std::size_t i = 0; i < kColumns; ++i) {
      if (std::ranges::count(names, kNames[i]) != 1 || names.size() != kColumns) {
        fail("the header does not name the seven columns once each; write " + std::string(kHeader));
      }
      order[static_cast<std::size_t>(std::ranges::find(names, kNames[i]) - names.begin())] = i;
    }
    order_ = order;
  }

  void take_row(const std::vector<std::string_view>& row) {
    if (row.size() != kColumns) {
      fail(std::to_string(row.size()) + " values; write seven numbers, in the order of the header");
    }
    std::array<double, kColumns> values{};
    for (std::size_t column = 0; column < kColumns; ++column) {
      const std::size_t which = (*order_)[column];
      const auto value = number(row[column]);
      if (!value) {
        fail(std::string(kNames[which]) + ": \"" + std::string(row[column]) +
             "\" is not a number; write it with a point, e.g. -0.125");
      }
      values[which] = *value;
    }
    if (!samples_.empty() && values[0] <= samples_.back().t_s) {
      fail("t_s does not increase; sort the rows by time and leave doubles out");
    }
    constexpr double kDegree = std::numbers::pi / 180;
    plant::Vector6d eta;
    eta << values[1], values[2], values[3], kDegree * values[4], kDegree * values[5], kDegree * values[6];
    samples_.push_back({values[0], eta});
  }

  std::string_view name_;
  std::size_t line_ = 0;
  std::optional<Order> order_;
  std::vector<plant::RecordedMotion::Sample> samples_;
};

}  // namespace

plant::RecordedMotion read_motion_csv(std::istream& in, std::string_view name) {
  Reader reader(name);
  for (std::string line; std::getline(in, line);) reader.take(line);
  return reader.finish();
}

plant::RecordedMotion read_motion_csv(const std::filesystem::path& file) {
  std::ifstream in(file);
  if (!in) throw StartupError(file.string() + ": cannot be read; check the path after csv:");
  return read_motion_csv(in, file.string());
}

}  // namespace motionlab::lab
