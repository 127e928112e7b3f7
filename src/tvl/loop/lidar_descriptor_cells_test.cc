#include "tvl/loop/lidar_descriptor_cells.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tvl/base/rng.h"
#include "tvl/base/units.h"

namespace tvl {
namespace {

void Add(KeyframeCloud* cloud, double x, double y, double z) {
  cloud->planes.points.push_back(Eigen::Vector3d(x, y, z).cast<float>());
  cloud->planes.intensity.push_back(0.0F);
}

// Ground at z = -1.7 + slope x, a point every 0.8 m.
KeyframeCloud Ground(double slope) {
  KeyframeCloud cloud;
  for (double x = -39.6; x < 40.0; x += 0.8) {
    for (double y = -39.6; y < 40.0; y += 0.8) Add(&cloud, x, y, -1.7 + slope * x);
  }
  return cloud;
}

TEST(StandingCells, GroundDoesNotStand) {
  EXPECT_TRUE(StandingCells(Ground(0.0), {}).empty());
  EXPECT_TRUE(StandingCells(Ground(0.1), {}).empty());
  EXPECT_TRUE(StandingCells(KeyframeCloud{}, {}).empty());
}

TEST(StandingCells, CellAndLayersOfAPole) {
  KeyframeCloud cloud = Ground(0.0);
  for (double z = -1.6; z < 1.0; z += 0.1) Add(&cloud, 10.1, -5.2, z);  // up to 2.7 m
  const std::vector<PlaceCell> cells = StandingCells(cloud, {});
  ASSERT_EQ(cells.size(), 1u);
  EXPECT_EQ(cells[0].x, 16);  // 10.1 / 0.625
  EXPECT_EQ(cells[0].y, -9);
  EXPECT_EQ(cells[0].layers, 5);  // 0.5-1, 1-1.5, .. 2.5-3
  EXPECT_FLOAT_EQ(cells[0].weight(), std::sqrt(5.0F));
}

TEST(StandingCells, OnlyBetweenTheHeightsAndWithinTheRange) {
  KeyframeCloud cloud = Ground(0.0);
  Add(&cloud, 10.0, 0.0, -1.4);  // 0.3 m: a kerb
  Add(&cloud, 10.0, 4.0, 8.0);   // above
  Add(&cloud, 39.0, 39.0, 0.0);  // in a corner of the square, outside the circle
  Add(&cloud, 60.0, 0.0, 0.0);
  EXPECT_TRUE(StandingCells(cloud, {}).empty());
  Add(&cloud, 10.0, 0.0, 0.0);
  EXPECT_EQ(StandingCells(cloud, {}).size(), 1u);
}

TEST(GroundHeights, WallWithoutGroundStandsOnItsNeighbours) {
  KeyframeCloud cloud = Ground(0.0);
  auto& points = cloud.planes.points;
  const auto hidden = [](const Eigen::Vector3f& p) { return p.x() > 16.0F && p.x() < 24.0F; };
  points.erase(std::remove_if(points.begin(), points.end(), hidden), points.end());
  Add(&cloud, 18.0, 2.0, 3.0);
  const std::vector<float> ground_m = GroundHeights(cloud, 20, {});
  EXPECT_NEAR(ground_m[10 * 20 + 14], -1.7, 1.01);  // no steeper than 0.25 over 4 m
  EXPECT_NEAR(ground_m[10 * 20 + 5], -1.7, 1e-5);
}

TEST(GroundHeights, GhostBelowTheStreetIsIgnored) {
  KeyframeCloud cloud = Ground(0.0);
  Add(&cloud, 6.0, 2.0, -5.0);
  Add(&cloud, 6.1, 2.0, -5.1);
  for (const float z : GroundHeights(cloud, 20, {})) EXPECT_NEAR(z, -1.7, 1e-5);
}

TEST(GroundHeights, LowerEnvelopeMatchesBruteForce) {
  Rng rng(2);
  KeyframeCloud cloud;
  const int side = 20;
  std::vector<double> lowest(side * side, 1e9);
  for (int i = 0; i < 150; ++i) {  // one point a cell at most
    const int64_t x = rng.Integer(side), y = rng.Integer(side);
    double& z = lowest[static_cast<size_t>(y * side + x)];
    if (z < 1e8) continue;
    z = rng.Uniform(-4.0, 4.0);
    Add(&cloud, 4.0 * static_cast<double>(x) - 38.0, 4.0 * static_cast<double>(y) - 38.0, z);
  }
  const std::vector<float> ground_m = GroundHeights(cloud, side, {});
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      double expected = 1e9;
      for (int v = 0; v < side; ++v) {
        for (int u = 0; u < side; ++u) {
          const int dx = std::abs(u - x), dy = std::abs(v - y);
          const double steps = std::max(dx, dy) + (std::sqrt(2.0) - 1.0) * std::min(dx, dy);
          expected = std::min(expected, lowest[static_cast<size_t>(v * side + u)] + steps);
        }
      }
      EXPECT_NEAR(ground_m[static_cast<size_t>(y * side + x)], expected, 1e-4);
    }
  }
}

TEST(PlaceImage, TurnsAndKeepsTheWeight) {
  const LidarDescriptorOptions options;
  const std::vector<PlaceCell> cells{{16, 0, 4}, {-1, -30, 9}};
  const cv::Mat plain = PlaceImage(cells, 0.0, 128, options);
  EXPECT_FLOAT_EQ(plain.at<float>(64, 80), 2.0F);
  EXPECT_FLOAT_EQ(plain.at<float>(34, 63), 3.0F);
  for (const double yaw : {0.3, 2.0, kPi}) {
    EXPECT_NEAR(cv::sum(PlaceImage(cells, yaw, 128, options))[0], 5.0, 1e-4);
  }
  // A quarter turn takes (x, y) to (-y, x), cell by cell.
  EXPECT_NEAR(PlaceImage(cells, kPi / 2.0, 128, options).at<float>(80, 63), 2.0, 1e-3);
  EXPECT_NEAR(cv::sum(PlaceImage(cells, 0.3, 64, options))[0], 5.0, 1e-4);
}

}  // namespace
}  // namespace tvl
