#include "tvl/loop/lidar_descriptor_match.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tvl/base/rng.h"
#include "tvl/base/units.h"
#include "tvl/lidar/feature_extraction.h"
#include "tvl/lidar/real_scans.h"
#include "tvl/lidar/segmentation.h"
#include "tvl/lidar/test_scene.h"
#include "tvl/loop/lidar_descriptor_cells.h"
#include "tvl/loop/lidar_descriptor_test_world.h"

namespace tvl {
namespace {

using synthetic::OnGround;
using synthetic::Scan;
using synthetic::Street;
using synthetic::Town;

double Yaw(const Rigid3d& T) { return std::atan2(T.R()(1, 0), T.R()(0, 0)); }

void ExpectPlacement(const PlaceMatch& match, const Rigid3d& T_history_current,
                     double tolerance_m) {
  EXPECT_NEAR(std::remainder(match.yaw_rad - Yaw(T_history_current), 2.0 * kPi), 0.0,
              DegToRad(1.5));
  EXPECT_NEAR(match.x_m, T_history_current.t().x(), tolerance_m);
  EXPECT_NEAR(match.y_m, T_history_current.t().y(), tolerance_m);
}

TEST(SpectrumYaw, FindsTheTurnBetweenTheSamples) {
  Rng rng(1);
  std::vector<double> phase, cycles;
  for (int r = 0; r < 32; ++r) {
    phase.push_back(rng.Uniform(0.0, kPi));
    cycles.push_back(static_cast<double>(2 + rng.Integer(5)));
  }
  const auto spectrum = [&](double turn) {
    std::vector<int8_t> out;
    for (size_t r = 0; r < 32; ++r) {
      for (int a = 0; a < 64; ++a) {
        const double angle = kPi * a / 64.0 - turn - phase[r];
        out.push_back(static_cast<int8_t>(std::lround(22.0 * std::cos(2.0 * cycles[r] * angle))));
      }
    }
    return out;
  };
  for (double turn = 0.0; turn < kPi; turn += 0.037) {
    const double found = SpectrumYaw(spectrum(turn), spectrum(0.0));
    EXPECT_NEAR(std::remainder(found - turn, kPi), 0.0, DegToRad(0.3));
    EXPECT_GE(found, 0.0);
    EXPECT_LT(found, kPi);
  }
}

TEST(PlaceMatcher, FindsYawAndShiftForAnyHeading) {
  const Town town = Street(200.0, 3);
  const Rigid3d T_history = OnGround(100.0, -2.0, 0.1);
  const LidarDescriptor history = DescribePlace(Scan(town, T_history, 1), {});
  for (int i = 0; i < 12; ++i) {
    const Rigid3d T_current = OnGround(97.0 + 0.5 * i, 2.0, 2.0 * kPi * i / 12.0);
    const LidarDescriptor current =
        DescribePlace(Scan(town, T_current, 2 + static_cast<uint64_t>(i)), {});
    const PlaceMatch match = PlaceMatcher(current, 12.0, {}).Match(history);
    ExpectPlacement(match, T_history.Inverse() * T_current, 0.35);
    EXPECT_GT(match.similarity, 0.6);
    EXPECT_LT(match.ambiguity, 0.9);
  }
}

TEST(PlaceMatcher, OfItself) {
  const LidarDescriptor place = DescribePlace(Scan(Street(200.0, 3), OnGround(90, 0, 1), 1), {});
  const PlaceMatch match = PlaceMatcher(place, 12.0, {}).Match(place);
  EXPECT_NEAR(match.similarity, 1.0, 0.02);
  ExpectPlacement(match, {}, 0.05);
}

TEST(PlaceMatcher, NoBetterPlacementByBruteForce) {
  const Town town = Street(200.0, 4);
  const LidarDescriptorOptions options;
  const LidarDescriptor history = DescribePlace(Scan(town, OnGround(100, -2, 0), 1), options);
  const LidarDescriptor current = DescribePlace(Scan(town, OnGround(104, 1, 2.9), 2), options);
  const PlaceMatch match = PlaceMatcher(current, 12.0, options).Match(history);
  // The similarity by its definition: cells of one, turned and shifted, against the blurred image
  // of the other, which for points is a sum of small hills.
  const cv::Mat target = PlaceImage(history.cells, 0.0, options.grid(), options);
  const int half = options.grid() / 2;
  const auto similarity = [&](double yaw, double x, double y) {
    double sum = 0.0;
    for (const PlaceCell& a : current.cells) {
      const double ax = (a.x + 0.5) * options.cell_m, ay = (a.y + 0.5) * options.cell_m;
      const double u = (std::cos(yaw) * ax - std::sin(yaw) * ay + x) / options.cell_m + half - 0.5;
      const double v = (std::sin(yaw) * ax + std::cos(yaw) * ay + y) / options.cell_m + half - 0.5;
      for (int i = static_cast<int>(u) - 2; i <= static_cast<int>(u) + 3; ++i) {
        for (int j = static_cast<int>(v) - 2; j <= static_cast<int>(v) + 3; ++j) {
          if (i < 0 || j < 0 || i >= target.cols || j >= target.rows) continue;
          const double d_sq = (u - i) * (u - i) + (v - j) * (v - j);
          sum += a.weight() * target.at<float>(j, i) * std::exp(-0.5 * d_sq) / (2.0 * kPi);
        }
      }
    }
    return sum / std::sqrt(static_cast<double>(history.energy) * current.energy);
  };
  const double found = similarity(match.yaw_rad, match.x_m, match.y_m);
  EXPECT_NEAR(found, match.similarity, 0.08);
  double best = 0.0;
  for (double yaw = -kPi; yaw < kPi; yaw += DegToRad(6.0)) {
    for (double x = -12.0; x <= 12.0; x += 2.0) {
      for (double y = -12.0; y <= 12.0; y += 2.0) best = std::max(best, similarity(yaw, x, y));
    }
  }
  EXPECT_GE(found, best);
}

TEST(PlaceMatcher, AnotherStreetIsUnlike) {
  const LidarDescriptor a = DescribePlace(Scan(Street(200.0, 5), OnGround(100, 0, 0), 1), {});
  const LidarDescriptor b = DescribePlace(Scan(Street(200.0, 6), OnGround(100, 0, 2), 2), {});
  EXPECT_LT(PlaceMatcher(a, 12.0, {}).Match(b).similarity, 0.5);
}

TEST(PlaceMatcher, AlikeAllAlongIsAmbiguous) {
  Town hedges;
  hedges.AddWall({-200, 5}, {200, 5}, 2.0);
  hedges.AddWall({-200, -6}, {200, -6}, 2.0);
  const LidarDescriptor a = DescribePlace(Scan(hedges, OnGround(0, 0, 0), 1), {});
  const LidarDescriptor b = DescribePlace(Scan(hedges, OnGround(7, 0, 0), 2), {});
  EXPECT_GT(PlaceMatcher(b, 12.0, {}).Match(a).ambiguity, 0.9);
}

TEST(PlaceMatcher, NothingThere) {
  const LidarDescriptor none = DescribePlace(KeyframeCloud{}, {});
  const LidarDescriptor place = DescribePlace(Scan(Street(200.0, 3), OnGround(90, 0, 0), 1), {});
  EXPECT_EQ(PlaceMatcher(none, 12.0, {}).Match(place).similarity, 0.0);
  EXPECT_EQ(PlaceMatcher(place, 12.0, {}).Match(none).similarity, 0.0);
}

KeyframeCloud FeaturesOf(const std::string& file) {
  const LidarModel model = test::Hdl64();
  const SegmentedScan scan = SegmentScan(test::ReadKittiScan(file), model, Deskew::kNone, {});
  const LaserFeatures features = ExtractLaserFeatures(scan, model, {});
  KeyframeCloud cloud;
  for (const LaserFeature& f : features.less_sharp) cloud.edges.points.push_back(f.p_lidar);
  for (const LaserFeature& f : features.less_flat) cloud.planes.points.push_back(f.p_lidar);
  cloud.edges.intensity.resize(cloud.edges.points.size());
  cloud.planes.intensity.resize(cloud.planes.points.size());
  return cloud;
}

// A real street, about 1 m a frame: the scan five frames later, as if driven in the other
// direction.
TEST(PlaceMatcher, RealStreetInTheOtherDirection) {
  if (test::TestData().empty()) GTEST_SKIP() << "TVL_TEST_DATA is not set";
  const std::string folder = test::TestData() + "/sequences/kitti360_3000/velodyne/";
  const LidarDescriptor history = DescribePlace(FeaturesOf(folder + "000010.bin"), {});
  KeyframeCloud cloud = FeaturesOf(folder + "000015.bin");
  for (FeatureCloud* part : {&cloud.edges, &cloud.planes}) {
    for (Eigen::Vector3f& p : part->points) p = Eigen::Vector3f(-p.x(), -p.y(), p.z());
  }
  const PlaceMatch match = PlaceMatcher(DescribePlace(cloud, {}), 12.0, {}).Match(history);
  EXPECT_GT(match.similarity, 0.6);
  EXPECT_NEAR(std::abs(match.yaw_rad), kPi, DegToRad(3.0));
  EXPECT_NEAR(match.x_m, 5.0, 0.7);
  EXPECT_NEAR(match.y_m, 0.0, 0.5);
}

}  // namespace
}  // namespace tvl
