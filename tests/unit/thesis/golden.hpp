/// @file  Reference values of an independent computation.
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

namespace motionlab::thesis {

inline const nlohmann::json& golden(const std::string& name) {
  static std::map<std::string, nlohmann::json> read;
  auto& json = read[name];
  if (json.is_null()) {
    std::ifstream file(std::string(MOTIONLAB_SOURCE_DIR) + "/tests/golden/thesis_" + name + ".json");
    json = nlohmann::json::parse(file);
  }
  return json;
}

inline Eigen::MatrixXd matrix(const nlohmann::json& rows) {
  if (!rows.at(0).is_array()) {
    Eigen::VectorXd v(static_cast<Eigen::Index>(rows.size()));
    for (std::size_t i = 0; i < rows.size(); ++i) v[static_cast<Eigen::Index>(i)] = rows[i].get<double>();
    return v;
  }
  Eigen::MatrixXd m(static_cast<Eigen::Index>(rows.size()), static_cast<Eigen::Index>(rows[0].size()));
  for (std::size_t i = 0; i < rows.size(); ++i) {
    for (std::size_t j = 0; j < rows[i].size(); ++j) {
      m(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) = rows[i][j].get<double>();
    }
  }
  return m;
}

/// Equal entry by entry, relative to the largest entry of what is expected.
inline void expect_close(const Eigen::MatrixXd& ours, const Eigen::MatrixXd& expected, double relative,
                         const std::string& what) {
  ASSERT_EQ(ours.rows(), expected.rows()) << what;
  ASSERT_EQ(ours.cols(), expected.cols()) << what;
  EXPECT_LE((ours - expected).cwiseAbs().maxCoeff(), relative * expected.cwiseAbs().maxCoeff())
      << what << "\nours\n"
      << ours << "\nexpected\n"
      << expected;
}

}  // namespace motionlab::thesis
