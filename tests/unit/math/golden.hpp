/// @file  Golden numbers for tests: JSON files of tests/golden, as matrices.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>

namespace motionlab::test {

using Json = nlohmann::json;

inline Json golden(const std::string& name) {
  std::ifstream file(MOTIONLAB_SOURCE_DIR "/tests/golden/" + name);
  return Json::parse(file);
}

inline Eigen::MatrixXd matrix(const Json& rows) {
  if (!rows.at(0).is_array()) {  // a vector is a column
    Eigen::VectorXd column(static_cast<Eigen::Index>(rows.size()));
    for (std::size_t i = 0; i < rows.size(); ++i)
      column[static_cast<Eigen::Index>(i)] = rows.at(i).get<double>();
    return column;
  }
  Eigen::MatrixXd M(static_cast<Eigen::Index>(rows.size()), static_cast<Eigen::Index>(rows.at(0).size()));
  for (std::size_t i = 0; i < rows.size(); ++i)
    M.row(static_cast<Eigen::Index>(i)) = matrix(rows.at(i)).transpose();
  return M;
}

/// A vector or matrix of fixed size.
template <int Rows, int Columns = 1>
Eigen::Matrix<double, Rows, Columns> fixed(const Json& values) {
  Eigen::Matrix<double, Rows, Columns> M;
  for (int i = 0; i < Rows; ++i) {
    const Json& row = values.at(static_cast<std::size_t>(i));
    for (int j = 0; j < Columns; ++j)
      M(i, j) = row.is_array() ? row.at(static_cast<std::size_t>(j)).template get<double>()
                               : row.template get<double>();
  }
  return M;
}

/// The largest deviation, relative to the largest golden entry (but at least to one hundredth, below which
/// golden numbers are rounding themselves); infinite when the shapes differ.
template <class Value, class Expected>
double deviation(const Eigen::DenseBase<Value>& value, const Eigen::DenseBase<Expected>& expected) {
  const auto v = value.derived().eval();
  const auto e = expected.derived().eval();
  double largest = 0, size = 0.01;
  for (Eigen::Index j = 0; j < e.cols(); ++j) {
    for (Eigen::Index i = 0; i < e.rows(); ++i) {
      largest = std::max(largest, std::abs(v(i, j) - e(i, j)));
      size = std::max(size, std::abs(e(i, j)));
    }
  }
  return v.rows() == e.rows() && v.cols() == e.cols() ? largest / size
                                                      : std::numeric_limits<double>::infinity();
}

}  // namespace motionlab::test
