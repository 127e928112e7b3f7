#include "map_thickness.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tvl/base/rng.h"

namespace tvl {
namespace {

constexpr int kScans = 6;

// Scans of the wall y = 10.25 from 10 m ahead to 10 m behind, the sensor moving along it.
std::vector<Eigen::Vector3f> Wall(double x_m, double noise_m, Rng* rng) {
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < 20000; ++i) {
    const Eigen::Vector3d p(rng->Uniform(-10.0, 10.0) - x_m, 10.25 + noise_m * rng->Normal(),
                            rng->Uniform(-2.0, 2.0));
    points.push_back(p.cast<float>());
  }
  return points;
}

Thickness OfWall(double noise_m, double pose_error_m) {
  Rng rng(1);
  ThicknessMeter meter;
  for (int k = 0; k < kScans; ++k) {
    const double x_m = 0.5 * k;
    meter.Add(Wall(x_m, noise_m, &rng), Rigid3d::Translation(x_m, pose_error_m * (k % 2), 0.0));
  }
  return meter.Result();
}

TEST(MapThickness, IsTheNoiseOfTheScansIfPosesAreRight) {
  const Thickness result = OfWall(0.02, 0.0);
  EXPECT_NEAR(result.rms_m, 0.02, 5e-4);
  EXPECT_EQ(result.planar_voxels, result.filled_voxels);
  EXPECT_GT(result.planar_voxels, 300);
}

TEST(MapThickness, GrowsWithTheErrorOfPoses) {
  // Every second scan is 6 cm off: 3 cm to either side of the mean.
  EXPECT_NEAR(OfWall(0.02, 0.06).rms_m, std::hypot(0.02, 0.03), 1e-3);
}

TEST(MapThickness, NeedsSeveralScans) {
  Rng rng(1);
  ThicknessMeter meter;
  meter.Add(Wall(0.0, 0.02, &rng), Rigid3d());
  meter.Add(Wall(0.0, 0.02, &rng), Rigid3d());
  EXPECT_EQ(meter.Result().filled_voxels, 0);
}

}  // namespace
}  // namespace tvl
