#include "tvl/depth/local_plane.h"

#include <gtest/gtest.h>

#include "tvl/base/rng.h"
#include "tvl/base/units.h"

namespace tvl {
namespace {

// Where the ray (x, y, 1) meets n^T X + d = 0.
double DepthOn(const Eigen::Vector3d& n, double d, double x, double y) {
  return -d / n.dot(Eigen::Vector3d(x, y, 1.0));
}

std::vector<ProjectedPoint> Sample(const Eigen::Vector3d& n, double d, double sigma_m, int count,
                                   uint64_t seed) {
  Rng rng(seed);
  std::vector<ProjectedPoint> points;
  for (int i = 0; i < count; ++i) {
    const double x = 0.1 + rng.Uniform(-0.01, 0.01), y = 0.12 + 0.008 * (i % 3);
    points.push_back({static_cast<float>(x), static_cast<float>(y),
                      static_cast<float>(DepthOn(n, d, x, y) + sigma_m * rng.Normal()), 2,
                      static_cast<uint16_t>(i % 3)});
  }
  return points;
}

const Eigen::Vector3d kGroundNormal(0.0, 1.0, 0.0);  // camera y points down; ground 1.65 m below
constexpr double kGround_d = -1.65;
const Eigen::Vector2d kRay(0.1, 0.128);

TEST(LocalPlane, IntersectsTheRayExactly) {
  const LocalPlane plane = FitPlane(Sample(kGroundNormal, kGround_d, 0.0, 12, 1));
  ASSERT_TRUE(plane.valid);
  EXPECT_NEAR(1.0 / plane.InverseDepth(kRay), 1.65 / 0.128, 1e-3);
  EXPECT_NEAR(plane.rms_m, 0.0, 1e-3);
  const double sin_a = 0.128 / kRay.homogeneous().norm();
  EXPECT_NEAR(plane.SinIncidence(kRay), sin_a, 1e-3);
}

TEST(LocalPlane, BehindTheCameraIsNegative) {
  // Near points that recede as the ray turns towards a plane behind.
  const std::array<ProjectedPoint, 3> corners = {ProjectedPoint{0.00f, 0.0f, 5.0f, 0, 0},
                                                 ProjectedPoint{0.01f, 0.0f, 50.0f, 0, 0},
                                                 ProjectedPoint{0.00f, 0.01f, 5.0f, 0, 1}};
  const LocalPlane plane = PlaneThrough(corners);
  ASSERT_TRUE(plane.valid);
  EXPECT_LT(plane.InverseDepth({0.02, 0.0}), 0.0);
}

TEST(LocalPlane, OneLineSpansNoPlane) {
  std::vector<ProjectedPoint> line;
  for (int i = 0; i < 8; ++i) line.push_back({0.002f * static_cast<float>(i), 0.1f, 9.0f, 0, 0});
  EXPECT_FALSE(FitPlane(line).valid);
  EXPECT_FALSE(FitPlane({line[0], line[1]}).valid);
}

// The spread of fitted depths over many noisy samples agrees with the predicted one.
TEST(LocalPlane, LeveragePredictsTheError) {
  const Eigen::Vector3d wall = Eigen::Vector3d(0.3, 0.0, -1.0).normalized();
  const double d = 15.0, sigma_m = 0.02;
  const double truth_m = DepthOn(wall, d, kRay.x(), kRay.y());
  double sum = 0.0, predicted = 0.0;
  const int runs = 400;
  for (int run = 0; run < runs; ++run) {
    const LocalPlane plane =
        FitPlane(Sample(wall, d, sigma_m, 18, 100 + static_cast<uint64_t>(run)));
    sum += std::pow(1.0 / plane.InverseDepth(kRay) - truth_m, 2);
    predicted += sigma_m * sigma_m * plane.Leverage(kRay) / runs;
  }
  EXPECT_NEAR(std::sqrt(sum / runs) / std::sqrt(predicted), 1.0, 0.25);
}

TEST(LocalPlane, OneLeafInFrontCountsLittle) {
  const Eigen::Vector3d wall(0.0, 0.0, -1.0);
  std::vector<ProjectedPoint> points = Sample(wall, 15.0, 0.01, 18, 3);
  points[4].depth_m = 14.0f;
  EXPECT_NEAR(1.0 / FitPlane(points).InverseDepth(kRay), 15.0, 0.03);
}

TEST(LocalPlane, LargestTriangleMatchesBruteForce) {
  Rng rng(8);
  std::vector<ProjectedPoint> points;
  for (int i = 0; i < 30; ++i) {
    const int ring = i % 4;
    points.push_back({static_cast<float>(rng.Uniform(-0.01, 0.01)),
                      0.006f * static_cast<float>(ring), 8.0f, 2, static_cast<uint16_t>(ring)});
  }
  double best = 0.0;
  for (const auto& a : points) {
    for (const auto& b : points) {
      for (const auto& c : points) {
        best = std::max(best, 0.5 * std::abs(static_cast<double>((b.x - a.x) * (c.y - a.y) -
                                                                 (c.x - a.x) * (b.y - a.y))));
      }
    }
  }
  EXPECT_NEAR(FindLargestTriangle(points).area_rad_sq, best, 1e-9);
  EXPECT_EQ(FindLargestTriangle({points[0], points[1]}).area_rad_sq, 0.0);
}

}  // namespace
}  // namespace tvl
