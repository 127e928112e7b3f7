#include "tvl/lidar/feature_extraction.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tvl/base/check.h"
#include "tvl/lidar/range_image.h"
#include "tvl/lidar/test_scene.h"

namespace tvl {
namespace {

using test::Box;
using test::Plane;
using test::Surface;

// All points in one cluster.
SegmentedScan OneCluster(const std::vector<Surface>& world, double noise_m, uint64_t seed = 1) {
  const LidarModel model = test::Hdl64();
  const test::SimulatedScan sim = test::Scan(world, model, noise_m, seed);
  RingAssignment rings;
  rings.row = sim.ring;
  rings.rows = model.rows();
  SegmentedScan scan = BuildRangeImage(sim.scan, ComputeScanGeometry(sim.scan), rings, model,
                                       Deskew::kCounterClockwise)
                           .scan;
  scan.label.assign(scan.size(), kFirstClusterLabel);
  scan.clusters = 1;
  return scan;
}

LaserFeatures Extract(const SegmentedScan& scan, const LaserFeatureOptions& options = {}) {
  return ExtractLaserFeatures(scan, test::Hdl64(), options);
}

// No limits on the number of edges, no distance between them: every point above the threshold.
LaserFeatureOptions AllEdges() {
  LaserFeatureOptions options;
  options.less_sharp_per_subregion = 100000;
  return options;
}

TEST(Features, NoisyFlatWallGivesNoEdges) {
  for (const double distance_m : {3.0, 4.0, 5.0, 8.0, 10.0, 15.0, 20.0, 30.0}) {
    const double half_m = std::min(distance_m, 8.0);  // seen at up to 45 deg
    const SegmentedScan wall =
        OneCluster({Plane({1, 0, 0}, distance_m,
                          [=](const Eigen::Vector3d& p) { return std::abs(p.y()) < half_m; })},
                   0.02);
    // Every point is asked, not only those that pass the picking.
    size_t edges = 0, asked = 0;
    for (size_t begin = 0, end = 0; begin < wall.size(); begin = end) {
      RingPoints ring;
      for (end = begin; end < wall.size() && wall.ring[end] == wall.ring[begin]; ++end) {
        ring.range_m.push_back(wall.points[end].norm());
        ring.angle_rad.push_back(static_cast<float>(kPi) -
                                 std::atan2(wall.points[end].y(), wall.points[end].x()));
      }
      const auto curvature = ComputeCurvature(ring, 2.0 * kPi / 2048, {});
      for (size_t i = 0; i < curvature.size(); ++i) {
        if (curvature[i].window == 0 || curvature[i].unreliable) continue;
        edges += curvature[i].c > EdgeThreshold(ring.range_m[i], test::Hdl64(), {});
        ++asked;
      }
    }
    EXPECT_GT(asked, 0.8 * static_cast<double>(wall.size()));
    EXPECT_LT(static_cast<double>(edges), 0.01 * static_cast<double>(asked)) << distance_m << " m";
    const LaserFeatures features = Extract(wall, AllEdges());
    EXPECT_LT(static_cast<double>(features.less_sharp.size()),
              0.01 * static_cast<double>(wall.size()));
    EXPECT_GT(features.flat.size(), 4 * 20u);
  }
}

TEST(Features, SlantedWallsAndMissingPointsGiveNoEdges) {
  // A wall along the street, seen at down to 8 deg, with every seventh column missing.
  SegmentedScan street = OneCluster(
      {Plane({0, 1, 0}, 4.0,
             [](const Eigen::Vector3d& p) {
               const int column = static_cast<int>(std::atan2(p.y(), p.x()) / (2.0 * kPi) * 2048.0);
               return p.x() > 0.0 && p.x() < 28.0 && column % 7 != 0;
             })},
      0.01);
  const LaserFeatures features = Extract(street, AllEdges());
  EXPECT_LT(static_cast<double>(features.less_sharp.size()),
            0.01 * static_cast<double>(street.size()));
}

// Two walls that meet at a right angle at (distance, 0), towards the sensor or away from it.
std::vector<Surface> Corner(double distance_m, bool towards) {
  const double s = towards ? 1.0 : -1.0;
  const Eigen::Vector3d left(1, -s, 0), right(1, s, 0);
  const double reach_m = 3.0;
  return {Plane(left, distance_m,
                [=](const Eigen::Vector3d& p) { return p.y() >= 0.0 && p.y() < reach_m; }),
          Plane(right, distance_m,
                [=](const Eigen::Vector3d& p) { return p.y() < 0.0 && p.y() > -reach_m; })};
}

TEST(Features, RightAngledCornerIsFoundAt5And10And20m) {
  for (const bool towards : {true, false}) {
    for (const double distance_m : {5.0, 10.0, 20.0}) {
      const SegmentedScan scan = OneCluster(Corner(distance_m, towards), 0.02);
      int rows = 0, found = 0;
      std::vector<uint8_t> row_seen(64, 0), row_found(64, 0);
      for (const uint16_t ring : scan.ring) row_seen[ring] = 1;
      const LaserFeatures features = Extract(scan);
      for (const LaserFeature& f : features.sharp) {
        if (std::abs(f.p_lidar.y()) < 0.15f) row_found[f.ring] = 1;
      }
      for (size_t r = 0; r < 64; ++r) rows += row_seen[r], found += row_found[r];
      EXPECT_GT(found, 0.9 * rows) << distance_m << " m " << (towards ? "towards" : "away");
    }
  }
}

TEST(Features, FarSideOfAnOcclusionIsNoFeature) {
  // A box in front of a wall: its own borders are edges, the wall beside them is not.
  const SegmentedScan scan =
      OneCluster({Box({8, -1, -5}, {9, 1, 5}),
                  Plane({1, 0, 0}, 15.0, [](const auto& p) { return std::abs(p.y()) < 10.0; })},
                 0.01);
  const LaserFeatures features = Extract(scan);
  int on_box = 0, beside = 0;
  for (const LaserFeature& f : features.sharp) {
    if (f.p_lidar.x() < 10.0f) ++on_box;
    if (f.p_lidar.x() > 10.0f && std::abs(f.p_lidar.y()) < 3.0f) ++beside;
  }
  EXPECT_GT(on_box, 80);
  EXPECT_EQ(beside, 0);
  for (const LaserFeature& f : features.sharp) {
    if (f.p_lidar.x() < 10.0f) {
      EXPECT_GT(std::abs(f.p_lidar.y()), 0.85f) << "inside the box's face";
    }
  }
}

TEST(Features, SurfaceAlongTheBeamIsRejected) {
  RingPoints ring;
  for (int i = 0; i < 200; ++i) {
    ring.angle_rad.push_back(0.003f * static_cast<float>(i));
    // A ramp of 3 % of the range from point to point in the middle.
    ring.range_m.push_back(
        i < 80 ? 5.0f : (i < 120 ? 5.0f * std::pow(1.03f, static_cast<float>(i - 79)) : 16.0f));
  }
  const auto curvature = ComputeCurvature(ring, 0.003, {});
  EXPECT_TRUE(curvature[100].unreliable);
  EXPECT_FALSE(curvature[40].unreliable);
  EXPECT_FALSE(curvature[160].unreliable);
}

TEST(Curvature, IsEquationOneWhereRangesAreAlikeAndEvenlySpaced) {
  Rng rng(9);
  RingPoints ring;
  for (int i = 0; i < 2000; ++i) {
    ring.angle_rad.push_back(static_cast<float>(2.0 * kPi * i / 2000));
    ring.range_m.push_back(50.0f + 0.1f * static_cast<float>(rng.Normal()));
  }
  const auto curvature = ComputeCurvature(ring, 2.0 * kPi / 2048, {});
  for (const int i : {0, 1, 500, 1000, 1998, 1999}) {  // around the ends too
    double sum = 0.0;
    for (int j = -5; j <= 5; ++j) {
      sum += static_cast<double>(ring.range_m[static_cast<size_t>((i + j + 2000) % 2000)] -
                                 ring.range_m[static_cast<size_t>(i)]);
    }
    const double c =
        std::abs(sum) / (10.0 * static_cast<double>(ring.range_m[static_cast<size_t>(i)]));
    EXPECT_EQ(curvature[static_cast<size_t>(i)].window, 5);
    EXPECT_NEAR(curvature[static_cast<size_t>(i)].c, c, 3e-5) << i;
  }
}

TEST(Features, CountsSpacingAndFields) {
  SegmentedScan scan = OneCluster({Plane({0, 0, 1}, -1.7), Box({6, -2, -1.7}, {8, 2, 1}),
                                   Plane({0, 1, 0}, 9.0), Plane({0.2, 1, 0}, -7.0)},
                                  0.02);
  for (size_t i = 0; i < scan.size(); ++i) {
    if (scan.points[i].z() < -1.6f) scan.label[i] = kLabelGround;
    if (scan.points[i].y() < -4.0f && scan.label[i] != kLabelGround) {
      scan.label[i] = kLabelOutlier;
    }
  }
  const LaserFeatures features = Extract(scan);
  EXPECT_LE(features.sharp.size(), 64u * 6u * 2u);
  EXPECT_LE(features.flat.size(), 64u * 6u * 4u);
  EXPECT_LE(features.less_sharp.size(), 64u * 6u * 20u);
  EXPECT_GE(features.less_sharp.size(), features.sharp.size());
  EXPECT_GT(features.sharp.size(), 30u);
  EXPECT_GT(features.flat.size(), 500u);
  bool ground = false, wall = false;
  for (const LaserFeature& f : features.less_flat) {
    ground |= f.p_lidar.z() < -1.6f;
    wall |= f.p_lidar.z() > 0.0f && f.p_lidar.y() > 8.0f;
    EXPECT_FALSE(f.p_lidar.y() < -4.0f && f.p_lidar.z() > -1.5f) << "outlier";
  }
  EXPECT_TRUE(ground);
  EXPECT_TRUE(wall);
  for (const LaserFeature& f : features.less_sharp) {
    EXPECT_GT(f.p_lidar.z(), -1.6f) << "no edges from the ground";
    EXPECT_GE(f.curvature, 0.005f);
  }
  const auto azimuth = [](const LaserFeature& f) {
    return std::atan2(f.p_lidar.y(), f.p_lidar.x());
  };
  for (const LaserFeature& f : features.flat) {
    EXPECT_NEAR(f.time_offset_s, azimuth(f) / (2.0 * kPi) * 0.1, 1e-5);
  }
  for (const auto* picks : {&features.flat, &features.less_sharp}) {
    for (const LaserFeature& f : *picks) {
      for (const LaserFeature& g : *picks) {
        if (&f == &g || f.ring != g.ring) continue;
        const double gap = std::abs(std::remainder(azimuth(f) - azimuth(g), 2.0 * kPi));
        EXPECT_GT(gap, 4.9 * 2.0 * kPi / 2048) << "picks of a kind keep their distance";
      }
    }
  }
}

TEST(Features, EmptyScan) {
  const LaserFeatures features = Extract(SegmentedScan{});
  EXPECT_TRUE(features.sharp.empty() && features.flat.empty() && features.less_flat.empty());
}

TEST(Features, OptionsAreChecked) {
  LaserFeatureOptions options;
  options.Check();
  options.less_flat_voxel_m = 0.0;
  EXPECT_THROW(options.Check(), InputError);
}

}  // namespace
}  // namespace tvl
