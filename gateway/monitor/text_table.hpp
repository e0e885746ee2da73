/// @file  Lines of cells as a table for people.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <string>
#include <vector>

namespace motionlab::monitor {

/// Columns as wide as their widest cell; the last one is not padded.
template <std::size_t N>
[[nodiscard]] std::string text_table(const std::vector<std::array<std::string, N>>& lines) {
  std::array<std::size_t, N> width{};
  for (const auto& line : lines) {
    for (std::size_t i = 0; i < N; ++i) width[i] = std::max(width[i], line[i].size());
  }
  std::string text;
  for (const auto& line : lines) {
    for (std::size_t i = 0; i + 1 < N; ++i) text += line[i] + std::string(width[i] + 2 - line[i].size(), ' ');
    text += line[N - 1] + "\n";
  }
  return text;
}

}  // namespace motionlab::monitor
