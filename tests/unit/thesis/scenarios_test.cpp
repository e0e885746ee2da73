/// The thesis' scenarios against an independent computation of them: 1 % with ideal states, 3 % with a
/// filter.
#include "simulators/lab/thesis/scenario.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <map>

#include "simulators/lab/thesis/metrics.hpp"
#include "tests/unit/thesis/golden.hpp"

namespace motionlab::thesis {
namespace {

using nlohmann::json;

struct Case {
  std::string key;  ///< of the reference
  Request request;
};

void PrintTo(const Case& c, std::ostream* out) {
  *out << c.key;
}

/// rms and maxima by the reference's names.
std::map<std::string, double> by_name(const Metrics& m, bool on_ship) {
  std::map<std::string, double> values{{"phi_alpha_rms_deg", m.swing_axis_rms_deg[0]},
                                       {"phi_beta_rms_deg", m.swing_axis_rms_deg[1]},
                                       {"phi_alpha_max_deg", m.swing_axis_max_deg[0]},
                                       {"phi_beta_max_deg", m.swing_axis_max_deg[1]},
                                       {"tool_rms_m", m.tool_rms_m},
                                       {"load_rms_m", m.load_rms_m},
                                       {"load_rms_xy_m", m.load_rms_xy_m},
                                       {"settle_1deg_s", m.settle_1deg_s},
                                       {"u_max", m.command_max_mps2},
                                       {"reach_max_m", m.reach_max_m}};
  if (on_ship) {
    values["load_rms_z_m"] = m.load_rms_z_m;
    values["tool_world_rms_m"] = m.tool_world_rms_m;
  } else {
    values["tool_rms_xy_m"] = m.tool_rms_xy_m;
    values["u_rms"] = m.command_rms_mps2;
  }
  return values;
}

void expect_metrics(const Metrics& m, const json& expected, bool on_ship, double tolerance) {
  for (const auto& [name, value] : by_name(m, on_ship)) {
    ASSERT_TRUE(expected.contains(name)) << name;
    const double reference = expected[name].get<double>();
    EXPECT_NEAR(value, reference, tolerance * std::abs(reference) + 1e-9) << name;
  }
  EXPECT_EQ(m.settle_censored, expected["settle_censored"].get<bool>());
  EXPECT_EQ(m.reach_ok, expected["reach_ok"].get<bool>());
  if (!m.reach_ok) return;  // outside, joints have no meaning
  for (std::size_t i = 0; i < 3; ++i) {
    const double reference = expected["qd_max_deg_s"][i].get<double>();
    EXPECT_NEAR(m.joint_speed_max_degps[i], reference, tolerance * reference + 1e-9) << "joint " << i + 1;
    if (!on_ship) continue;
    EXPECT_NEAR(m.joint_min_deg[i], expected["q_min_deg"][i].get<double>(), tolerance * 5)
        << "joint " << i + 1;
    EXPECT_NEAR(m.joint_max_deg[i], expected["q_max_deg"][i].get<double>(), tolerance * 5)
        << "joint " << i + 1;
  }
}

class LoadScenario : public testing::TestWithParam<Case> {};

TEST_P(LoadScenario, HasTheMetricsOfTheReference) {
  const Case& c = GetParam();
  const double tolerance = c.request.estimator == "ideal" ? 0.01 : 0.03;
  const auto run = choose(c.request);
  expect_metrics(measure(run), golden("scenarios")["load"][c.key], false, tolerance);
}

std::vector<Case> load_cases() {
  std::vector<Case> cases;
  for (const std::string number : {"1", "2"}) {
    for (const std::string estimator : {"ideal", "ekf"}) {
      Request request;
      request.scenario = "thesis-load-" + number;
      request.estimator = estimator == "ideal" ? "ideal" : "ekf10";
      request.controller = "damper";
      cases.push_back({"sc" + number + " NL " + estimator, request});
      for (const std::string gains : {"text", "printed"}) {
        request.gains = gains;
        request.controller = "prefilter";
        cases.push_back({"sc" + number + " FPF " + estimator + " " + gains, request});
        request.controller = "integral";
        cases.push_back({"sc" + number + " IC " + estimator + " " + gains, request});
      }
    }
  }
  return cases;
}

std::string test_name(const testing::TestParamInfo<Case>& info) {
  std::string name = info.param.key;
  std::replace(name.begin(), name.end(), ' ', '_');
  return name;
}

INSTANTIATE_TEST_SUITE_P(Thesis, LoadScenario, testing::ValuesIn(load_cases()), test_name);

class MotionScenario : public testing::TestWithParam<Case> {};

TEST_P(MotionScenario, HasTheMetricsOfTheReference) {
  const Case& c = GetParam();
  const double tolerance = c.request.estimator == "ideal" ? 0.01 : 0.03;
  const auto run = choose(c.request);
  const json& expected = golden("scenarios")["motion"][c.key];
  MetricsCollector whole(run), later(run, 20);
  simulate(run, [&](const Sample& sample) {
    whole.take(sample);
    later.take(sample);
  });
  expect_metrics(whole.metrics(), expected, true, tolerance);
  if (expected.contains("after 20 s")) {
    SCOPED_TRACE("after 20 s");
    expect_metrics(later.metrics(), expected["after 20 s"], true, tolerance);
  }
}

std::vector<Case> motion_cases() {
  std::vector<Case> cases;
  for (const std::string number : {"1", "4", "5"}) {
    for (const std::string frame : {"world", "thesis"}) {
      for (const std::string estimator : {"ideal", "ekf35"}) {
        if (number == "4" && estimator != "ideal") continue;
        Request request;
        request.scenario = "thesis-motion-" + number;
        request.frame = frame;
        request.estimator = estimator;
        cases.push_back({"sc" + number + " " + frame + " " + estimator, request});
      }
    }
  }
  return cases;
}

INSTANTIATE_TEST_SUITE_P(Thesis, MotionScenario, testing::ValuesIn(motion_cases()), test_name);

}  // namespace
}  // namespace motionlab::thesis
