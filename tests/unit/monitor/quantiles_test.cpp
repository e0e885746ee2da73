#include "gateway/monitor/quantiles.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace motionlab::monitor {
namespace {

TEST(Quantiles, TellsTheNearestRank) {
  Quantiles quantiles{1, 1000};
  for (int i = 1; i <= 100; ++i) quantiles.add(i);
  EXPECT_EQ(quantiles.at(0.50), 50);
  EXPECT_EQ(quantiles.at(0.99), 99);
  EXPECT_EQ(quantiles.at(1.00), 100);
  EXPECT_EQ(quantiles.max(), 100);
}

TEST(Quantiles, RoundsToItsStep) {
  Quantiles quantiles{10, 100};
  quantiles.add(2.26);
  EXPECT_EQ(quantiles.at(0.5), 2.3);
  EXPECT_EQ(quantiles.max(), 2.3);
}

TEST(Quantiles, TellsTheGreatestSampleForAQuantileBeyondItsRange) {
  Quantiles quantiles{1, 10};
  for (int i = 0; i < 4; ++i) quantiles.add(1);
  quantiles.add(5000);
  EXPECT_EQ(quantiles.at(0.5), 1);
  EXPECT_EQ(quantiles.at(0.99), 5000);
  EXPECT_EQ(quantiles.max(), 5000);
}

TEST(Quantiles, DoesNotCountWhatIsNoDuration) {
  Quantiles quantiles{1, 10};
  quantiles.add(-1);
  quantiles.add(std::numeric_limits<double>::quiet_NaN());
  quantiles.add(std::numeric_limits<double>::infinity());
  EXPECT_TRUE(quantiles.empty());
}

TEST(Quantiles, OfOneSampleAreThatSample) {
  Quantiles quantiles{1, 10};
  quantiles.add(7);
  EXPECT_EQ(quantiles.at(0.01), 7);
  EXPECT_EQ(quantiles.at(0.99), 7);
}

}  // namespace
}  // namespace motionlab::monitor
