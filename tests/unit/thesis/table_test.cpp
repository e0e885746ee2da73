/// The table of the thesis is the recorded one.
#include "simulators/lab/thesis/table.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "simulators/lab/thesis/table_text.hpp"

namespace motionlab::thesis {
namespace {

TEST(ThesisTable, IsTheRecordedOne) {
  std::ifstream file(std::string(MOTIONLAB_SOURCE_DIR) + "/tests/golden/thesis_table.txt");
  std::stringstream recorded;
  recorded << file.rdbuf();
  std::istringstream ours(comparison_table());
  std::string line, expected;
  int number = 0;
  while (std::getline(ours, line)) {
    ++number;
    ASSERT_TRUE(std::getline(recorded, expected)) << "the recorded table ends before line " << number;
    ASSERT_EQ(line, expected) << "line " << number;
  }
  EXPECT_FALSE(std::getline(recorded, expected)) << "the recorded table goes on: " << expected;
}

TEST(ThesisTable, SaysOfEverythingPrintedWhetherItHolds) {
  std::istringstream table(comparison_table());
  std::string line, item;
  bool printed = false, verdict = true;
  int items = 0;
  const auto close = [&] {
    if (printed) {
      ++items;
      EXPECT_TRUE(verdict) << item;
    }
    printed = verdict = false;
    item.clear();
  };
  while (std::getline(table, line)) {
    if (line.empty()) {
      close();
      continue;
    }
    if (item.empty()) item = line;
    printed |= line.starts_with("  printed");
    verdict |= line.starts_with("  confirmed") || line.starts_with("  corrected");
  }
  close();
  EXPECT_GE(items, 25);
}

TEST(ThesisTableText, PutsOursUnderThePrinted) {
  TableText table;
  table.item("Eq 1  a number");
  table.printed(Eigen::VectorXd::Constant(1, 3.14), 2);
  table.ours("ours", Eigen::VectorXd::Constant(1, 3.1416), 4);
  table.confirmed();
  EXPECT_EQ(table.text(),
            "\nEq 1  a number\n"
            "  printed                                3.14\n"
            "  ours                                 3.1416   differs by 0.00160\n"
            "  confirmed\n");
}

TEST(ThesisTable, HasNoNegativeZero) {
  EXPECT_EQ(fixed(-0.0004, 2), "0.00");
  EXPECT_EQ(fixed(-0.006, 2), "-0.01");
  EXPECT_EQ(fixed(1.5, 1, 6), "   1.5");
}

}  // namespace
}  // namespace motionlab::thesis
