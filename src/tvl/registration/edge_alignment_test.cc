#include "tvl/registration/edge_alignment.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tvl/base/check.h"
#include "tvl/base/units.h"
#include "tvl/registration/test_edges.h"

namespace tvl {
namespace {

using test_edges::GivenExtrinsics;
using test_edges::Scene;
using test_edges::TestCamera;

EdgeProfiles Read(const cv::Mat& grey, const SegmentedScan& scan, const Rigid3d& T_cam_lidar) {
  return FindEdgeProfiles(grey, scan, scan.points, TestCamera(), T_cam_lidar, Vector6d::Zero(),
                          EdgeAlignmentOptions().max_edges);
}

// Some images tell; those read with what the first have told do not tell otherwise.
TEST(EdgeAlignment, FindsWhereTheCameraPoints) {
  for (const double size_deg : {0.0, 0.15, 0.5, 1.0}) {
    const Eigen::Vector3d error_rad = DegToRad(size_deg) * Eigen::Vector3d(0.6, -0.6, 0.53);
    const Rigid3d turn(ExpSo3(error_rad), Eigen::Vector3d::Zero());
    EdgeAlignment alignment{EdgeAlignmentOptions()};
    Eigen::Vector3d known_rad = Eigen::Vector3d::Zero();
    for (uint64_t seed = 1; seed <= 12; ++seed) {
      Scene scene(seed);
      const Rigid3d known(ExpSo3(known_rad), Eigen::Vector3d::Zero());
      alignment.Add(
          Read(scene.See(turn * GivenExtrinsics()), scene.Scan(), known * GivenExtrinsics()),
          {known_rad, 0.0});
      if (seed == 4) known_rad = alignment.estimate().rotation_rad;
    }
    const EdgeEstimate estimate = alignment.estimate();
    ASSERT_GE(estimate.images, 8) << size_deg;
    const Eigen::Vector3d left_rad = estimate.rotation_rad - error_rad;
    EXPECT_LT(std::abs(left_rad.x()), DegToRad(0.08)) << size_deg;
    EXPECT_LT(std::abs(left_rad.y()), DegToRad(0.04)) << size_deg;
    EXPECT_LT(std::abs(left_rad.z()), DegToRad(0.1)) << size_deg;
    const Eigen::Matrix3d covariance = estimate.information.inverse();
    EXPECT_LT(std::sqrt(covariance(1, 1)), DegToRad(0.1)) << "and knows it";
    EXPECT_LT(left_rad.dot(estimate.information * left_rad), 9.0) << size_deg;
  }
}

TEST(EdgeAlignment, SaysNothingOfImagesOfSomethingElse) {
  EdgeAlignment unrelated{EdgeAlignmentOptions()}, uniform{EdgeAlignmentOptions()},
      blind{EdgeAlignmentOptions()};
  for (uint64_t seed = 1; seed <= 8; ++seed) {
    Scene scene(seed), other(seed + 100);
    const SegmentedScan scan = scene.Scan();
    unrelated.Add(Read(other.See(GivenExtrinsics()), scan, GivenExtrinsics()), {});
    uniform.Add(Read(cv::Mat(300, 800, CV_8U, cv::Scalar(90)), scan, GivenExtrinsics()), {});
    blind.Add(Read(cv::Mat(), scan, GivenExtrinsics()), {});
    EXPECT_EQ(unrelated.estimate().images, 0) << seed;
  }
  EXPECT_EQ(uniform.estimate().images, 0);
  EXPECT_EQ(blind.estimate().images, 0);
}

TEST(EdgeAlignment, LooksAgainOnlyAfterSomeWay) {
  EdgeAlignment alignment{EdgeAlignmentOptions()};
  const auto at = [](double way_m) {
    return Rigid3d(Eigen::Quaterniond::Identity(), Eigen::Vector3d(way_m, 0.0, 0.0));
  };
  EXPECT_TRUE(alignment.IsDue(at(0.0)));
  for (int i = 0; i < 20; ++i) EXPECT_FALSE(alignment.IsDue(at(0.01 * i))) << "it stands";
  EXPECT_TRUE(alignment.IsDue(at(0.6)));
  EXPECT_FALSE(alignment.IsDue(at(1.6))) << "the next frame";
  EXPECT_TRUE(alignment.IsDue(at(2.6)));
}

TEST(EdgeAlignment, OptionsAreChecked) {
  EdgeAlignmentOptions options;
  options.max_images = 0;
  EXPECT_THROW(EdgeAlignment{options}, InputError);
  options = {};
  options.bias_up_rad = 0.0;
  EXPECT_THROW(options.Check(), InputError);
}

}  // namespace
}  // namespace tvl
