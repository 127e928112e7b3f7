#include "tvl/geometry/voxel_thinning.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <tuple>

#include "tvl/base/check.h"
#include "tvl/base/rng.h"
#include "tvl/base/units.h"

namespace tvl {
namespace {

std::tuple<int, int, int> VoxelOf(const Eigen::Vector3f& p, float voxel_m) {
  const Eigen::Array3i cell = (p / voxel_m).array().floor().cast<int>();
  return {cell.x(), cell.y(), cell.z()};
}

TEST(VoxelThinning, OneAVoxelTheMiddleOne) {
  Rng rng(2);
  std::vector<Eigen::Vector3f> points;
  std::map<std::tuple<int, int, int>, std::vector<uint32_t>> expected;
  for (uint32_t i = 0; i < 5000; ++i) {
    points.push_back(
        Eigen::Vector3d(rng.Uniform(-2, 2), rng.Uniform(-2, 2), rng.Uniform(-2, 2)).cast<float>());
    expected[VoxelOf(points.back(), 0.5f)].push_back(i);
  }
  const std::vector<uint32_t> kept = MiddleOfEachVoxel(points, 0.5);
  ASSERT_EQ(kept.size(), 512u);  // 8^3 voxels, 10 points each
  int lower = 0, upper = 0;
  for (size_t k = 0; k < kept.size(); ++k) {
    if (k > 0) {
      EXPECT_GT(kept[k], kept[k - 1]);
    }
    const std::vector<uint32_t>& all = expected[VoxelOf(points[kept[k]], 0.5f)];
    const bool is_lower = kept[k] == all[(all.size() - 1) / 2];
    const bool is_upper = kept[k] == all[all.size() / 2];
    EXPECT_TRUE(is_lower || is_upper);
    lower += is_lower && !is_upper;
    upper += is_upper && !is_lower;
  }
  EXPECT_NEAR(lower, upper, 60);  // the two middle ones of even numbers alike
}

TEST(VoxelThinning, ManyVoxels) {
  std::vector<Eigen::Vector3f> points;
  for (int round = 0; round < 2; ++round) {
    for (int i = 0; i < 60000; ++i) {
      points.emplace_back(0.1f * static_cast<float>(i % 300) - 14.95f,
                          0.1f * static_cast<float>(i / 300) - 9.95f, 0.05f);
    }
  }
  EXPECT_EQ(MiddleOfEachVoxel(points, 0.1).size(), 60000u);
  EXPECT_TRUE(MiddleOfEachVoxel({}, 0.1).empty());
  EXPECT_THROW(MiddleOfEachVoxel(points, 0.0), Error);
}

// Between two walls, range noise must not turn what is kept: mean of how far points ahead lie
// beyond the wall less those behind, left less right.
TEST(VoxelThinning, NoiseDoesNotTurnTheWalls) {
  constexpr double kWall_m = 6.0, kNoise_m = 0.02;
  Rng rng(3);
  double ahead_less_behind_m[2] = {0.0, 0.0};  // left, right
  int count = 0;
  for (int scan = 0; scan < 40; ++scan) {
    std::vector<Eigen::Vector3f> points;
    for (int ring = 0; ring < 16; ++ring) {
      for (double azimuth = 0.0; azimuth < 2.0 * kPi; azimuth += 0.003) {
        const double range_m = kWall_m / std::abs(std::sin(azimuth));
        if (range_m > 20.0) continue;
        const double noisy_m = range_m + kNoise_m * rng.Normal();
        points.push_back(Eigen::Vector3d(noisy_m * std::cos(azimuth), noisy_m * std::sin(azimuth),
                                         0.013 * range_m * ring)
                             .cast<float>());
      }
    }
    for (const uint32_t i : MiddleOfEachVoxel(points, 0.2)) {
      const Eigen::Vector3f& p = points[i];
      const double beyond_m = std::abs(p.y()) - kWall_m;
      ahead_less_behind_m[p.y() < 0.0f] += p.x() > 0.0f ? beyond_m : -beyond_m;
      ++count;
    }
  }
  const double turn_m = (ahead_less_behind_m[0] - ahead_less_behind_m[1]) / count;
  const double sigma_m = kNoise_m / std::sqrt(static_cast<double>(count));
  EXPECT_LT(std::abs(turn_m), 4.0 * sigma_m);
}

}  // namespace
}  // namespace tvl
