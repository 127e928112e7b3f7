#include "tvl/sim/terrain.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tvl::sim {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

TEST(TerrainTest, RollsGently) {
  const Terrain terrain = Terrain::Rolling(3), other = Terrain::Rolling(4);
  double steepest = 0.0, low = 1e9, high = -1e9;
  for (double x = -500; x < 500; x += 7.0) {
    const Vector2d p(x, 0.3 * x);
    steepest = std::max(steepest, std::acos(terrain.Normal(p).z()));
    low = std::min(low, terrain.Height(p)), high = std::max(high, terrain.Height(p));
  }
  EXPECT_LT(steepest, 0.05);
  EXPECT_GT(high - low, 0.3);
  EXPECT_NE(terrain.Height({10, 20}), other.Height({10, 20}));
}

// A ramp, driven along x.
TEST(TerrainTest, PassesThroughMeasuredHeights) {
  std::vector<Vector3d> samples;
  for (double x = 0; x < 200; x += 1.0) {
    samples.emplace_back(x, 0.0, 0.03 * x + std::sin(x / 40.0));
  }
  const Terrain terrain = Terrain::Through(samples);
  for (double x = 30; x < 170; x += 5.0) {
    const double expected = 0.03 * x + std::sin(x / 40.0);
    EXPECT_NEAR(terrain.Height({x, 0}), expected, 0.12) << x;
    EXPECT_NEAR(terrain.Height({x, 8}), expected, 0.2) << "beside the road, " << x;
  }
}

// There and back on one street, with a height that drifts by 2 m over the drive.
TEST(ConsistentHeightsTest, RevisitsGetOneHeight) {
  std::vector<Vector3d> samples;
  const auto real = [](double x) { return 2.0 * std::sin(x / 60.0); };
  for (int i = 0; i < 400; ++i) {
    const double x = i < 200 ? i : 400 - i, drift = 2.0 * i / 400.0;
    samples.emplace_back(x, i < 200 ? 0.0 : 3.5, real(x) + drift);
  }
  const std::vector<double> heights = ConsistentHeights(samples, 8.0);
  double worst = 0.0, steepest = 0.0;
  for (size_t i = 1; i < 150; ++i) {
    worst = std::max(worst, std::abs(heights[i] - heights[400 - i]));
    // The slope stays as measured but for the drift's share.
    const double slope = heights[i + 1] - heights[i];
    steepest = std::max(steepest, std::abs(slope - (samples[i + 1].z() - samples[i].z())));
  }
  EXPECT_LT(worst, 0.1);
  EXPECT_LT(steepest, 0.03);
}

}  // namespace
}  // namespace tvl::sim
