#include "tvl/lidar/segmentation.h"

#include <gtest/gtest.h>

#include "tvl/base/check.h"
#include "tvl/lidar/feature_extraction.h"
#include "tvl/lidar/real_scans.h"
#include "tvl/lidar/test_scene.h"

namespace tvl {
namespace {

using test::Box;
using test::Plane;

test::SimulatedScan Street(uint64_t seed = 1) {
  return test::Scan({Plane({0, 0, 1}, -1.73), Plane({0, 1, 0}, 9.0), Plane({0, 1, 0}, -8.0),
                     Box({10, 2, -1.73}, {14, 4, -0.3})},
                    test::Hdl64(), 0.02, seed);
}

TEST(SegmentScan, LabelsAStreet) {
  const test::SimulatedScan street = Street();
  const Segmentation s =
      SegmentScanWithEvidence(street.scan, test::Hdl64(), Deskew::kNone, SegmentationOptions{});
  EXPECT_EQ(s.evidence.rings_found, 64);
  EXPECT_EQ(s.scan.size() + static_cast<size_t>(s.evidence.hidden), street.scan.size());
  EXPECT_EQ(s.scan.label.size(), s.scan.size());
  EXPECT_EQ(std::count(s.scan.label.begin(), s.scan.label.end(), kLabelGround), s.evidence.ground);
  EXPECT_EQ(std::count(s.scan.label.begin(), s.scan.label.end(), kLabelOutlier),
            s.evidence.outliers);
  EXPECT_EQ(*std::max_element(s.scan.label.begin(), s.scan.label.end()),
            kFirstClusterLabel + s.scan.clusters - 1);
  EXPECT_LT(s.evidence.outliers, 0.15 * static_cast<double>(s.scan.size()));
}

TEST(SegmentScan, WorkspaceDoesNotAffectResults) {
  SegmentationWorkspace workspace;
  const SegmentationOptions options;
  const LidarModel model = test::Hdl64();
  SegmentScan(Street(2).scan, model, Deskew::kNone, options, &workspace);
  const test::SimulatedScan street = Street(3);
  const SegmentedScan a = SegmentScan(street.scan, model, Deskew::kClockwise, options, &workspace);
  const SegmentedScan b = SegmentScan(street.scan, model, Deskew::kClockwise, options);
  EXPECT_EQ(a.points, b.points);
  EXPECT_EQ(a.label, b.label);
  EXPECT_EQ(a.ring, b.ring);
  EXPECT_EQ(a.time_offset_s, b.time_offset_s);
  EXPECT_EQ(a.image.point, b.image.point);
}

TEST(SegmentScan, NothingUsable) {
  const SegmentedScan none =
      SegmentScan(LidarScan{}, test::Hdl64(), Deskew::kNone, SegmentationOptions{});
  EXPECT_EQ(none.size(), 0u);
  EXPECT_EQ(none.image.rows, 64);
  LidarScan zeros;
  zeros.points.assign(100, Eigen::Vector3f::Zero());
  EXPECT_EQ(SegmentScan(zeros, test::Hdl64(), Deskew::kNone, SegmentationOptions{}).size(), 0u);
}

TEST(SegmentScan, OptionsNameTheField) {
  SegmentationOptions options;
  options.Check();
  options.clusters.min_points = 0;
  try {
    options.Check();
    FAIL();
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find("clusters.min_points"), std::string::npos);
  }
}

TEST(SegmentScan, RealScans) {
  const std::string data = test::TestData();
  if (data.empty()) GTEST_SKIP() << "TVL_TEST_DATA is not set";
  for (const char* name :
       {"kitti360_3000/velodyne/000020.bin", "kitti_2011_09_26_0052/velodyne/000007.bin",
        "kitti_odometry_00_first10/velodyne/000003.bin"}) {
    SCOPED_TRACE(name);
    const LidarScan scan = test::ReadKittiScan(data + "/sequences/" + name);
    const Segmentation s =
        SegmentScanWithEvidence(scan, test::Hdl64(), Deskew::kNone, SegmentationOptions{});
    const double points = static_cast<double>(s.scan.size());
    EXPECT_GT(points, 95000);
    EXPECT_NEAR(s.evidence.ground_seed.c, -1.7, 0.1);  // the height KITTI states: 1.73 m
    EXPECT_GT(s.evidence.ground / points, 0.30);
    EXPECT_LT(s.evidence.ground / points, 0.65);
    EXPECT_LT(s.evidence.outliers / points, 0.15);
    EXPECT_GT(s.scan.clusters, 100);
    const LaserFeatures f = ExtractLaserFeatures(s.scan, test::Hdl64(), LaserFeatureOptions{});
    EXPECT_GT(f.sharp.size(), 350u);
    EXPECT_GT(f.flat.size(), 1300u);
    EXPECT_GT(f.less_sharp.size(), 1000u);
    EXPECT_GT(f.less_flat.size(), 7000u);
  }
}

}  // namespace
}  // namespace tvl
