/// @file  Lays numbers out for `--table`.
#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>

namespace motionlab::thesis {

/// Collects the text of a table, one printed thing after the other.
class TableText {
 public:
  /// A chapter of the table.
  void section(std::string_view title);
  /// What the thesis prints next.
  void item(std::string_view title);
  /// As printed, with `decimals` as printed. What ours is compared with until the next one.
  void printed(const Eigen::VectorXd& values, int decimals);
  /// Ours, under its name, and the largest difference from what is printed.
  void ours(std::string_view name, const Eigen::VectorXd& values, int decimals);
  /// Numbers that have no printed counterpart.
  void numbers(std::string_view name, const Eigen::VectorXd& values, int decimals);
  void confirmed(std::string_view remark = "");
  void corrected(std::string_view why);
  /// Plain text.
  void line(std::string_view text);

  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  void row(std::string_view name, const Eigen::VectorXd& values, int decimals, std::string_view remark);

  std::string text_;
  Eigen::VectorXd printed_;
};

/// A number with so many decimals, never a negative zero. @param width  right-aligned in so many characters
[[nodiscard]] std::string fixed(double value, int decimals, int width = 0);

}  // namespace motionlab::thesis
