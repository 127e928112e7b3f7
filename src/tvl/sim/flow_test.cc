#include "tvl/sim/flow.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace tvl::sim {
namespace {

TEST(FlowTest, ConstantSpeedGoesOnForEver) {
  const Flow flow(5.0);
  EXPECT_DOUBLE_EQ(flow.Way_m(0.0), 0.0);
  EXPECT_DOUBLE_EQ(flow.Way_m(-3.0), -15.0);
  EXPECT_DOUBLE_EQ(flow.Way_m(12.5), 62.5);
  EXPECT_NEAR(Flow(-5.0).Speed_m_s(100.0), -5.0, 1e-9);
}

TEST(FlowTest, WayIsTheIntegralOfTheSpeed) {
  const Flow flow({0.0, 2.0, 2.0}, -1.0, 1.0);
  EXPECT_DOUBLE_EQ(flow.Way_m(0.0), 0.0);
  EXPECT_DOUBLE_EQ(flow.Way_m(-1.0), -1.0);
  EXPECT_DOUBLE_EQ(flow.Way_m(0.5), 1.0);
  EXPECT_DOUBLE_EQ(flow.Way_m(9.0), 2.0) << "stands after its end";
  EXPECT_DOUBLE_EQ(flow.Way_m(-9.0), -1.0);
}

TEST(FlowTest, StopAndGoStandsAndRollsWithoutJerks) {
  Rng rng(3);
  const Flow flow = StopAndGo({}, -20.0, 100.0, &rng);
  int standing = 0, rolling = 0;
  for (double t = 0.0; t < 99.0; t += 0.1) {
    const double speed = flow.Speed_m_s(t);
    EXPECT_GE(speed, -1e-9);
    EXPECT_LT(speed, 3.01);
    EXPECT_LT(std::abs(flow.Speed_m_s(t + 0.1) - speed) / 0.1, 1.3) << "m/s^2";
    standing += speed < 1e-6 ? 1 : 0;
    rolling += speed > 0.8 ? 1 : 0;
  }
  EXPECT_GT(standing, 50);
  EXPECT_GT(rolling, 300);
}

}  // namespace
}  // namespace tvl::sim
