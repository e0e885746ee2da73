#include "simulators/lab/thesis/table_text.hpp"

#include <array>
#include <cmath>
#include <cstdio>

namespace motionlab::thesis {

std::string fixed(double value, int decimals, int width) {
  if (std::abs(value) < 0.5 * std::pow(10.0, -decimals)) value = 0;
  std::array<char, 64> text;
  const int length = std::snprintf(text.data(), text.size(), "%*.*f", width, decimals, value);
  return {text.data(), static_cast<std::size_t>(length)};
}

void TableText::section(std::string_view title) {
  if (!text_.empty()) text_ += '\n';
  text_.append(title).append("\n").append(title.size(), '=').append("\n");
}

void TableText::item(std::string_view title) {
  text_.append("\n").append(title).append("\n");
  printed_.resize(0);
}

void TableText::row(std::string_view name, const Eigen::VectorXd& values, int decimals,
                    std::string_view remark) {
  text_.append("  ").append(name).append(name.size() < 32 ? 32 - name.size() : 1, ' ');
  for (const double value : values) text_ += fixed(value, decimals, 11);
  text_.append(remark).append("\n");
}

void TableText::printed(const Eigen::VectorXd& values, int decimals) {
  row("printed", values, decimals, "");
  printed_ = values;
}

void TableText::ours(std::string_view name, const Eigen::VectorXd& values, int decimals) {
  const double difference = (values - printed_).cwiseAbs().maxCoeff();
  row(name, values, decimals, "   differs by " + fixed(difference, decimals + 1));
}

void TableText::numbers(std::string_view name, const Eigen::VectorXd& values, int decimals) {
  row(name, values, decimals, "");
}

void TableText::confirmed(std::string_view remark) {
  text_.append(remark.empty() ? "  confirmed" : "  confirmed; ").append(remark).append("\n");
}

void TableText::corrected(std::string_view why) {
  text_.append("  corrected: ").append(why).append("\n");
}

void TableText::line(std::string_view text) {
  text_.append("  ").append(text).append("\n");
}

}  // namespace motionlab::thesis
